#include "frontend/core/features/disparity_refiner.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <array>
#include <cmath>

namespace gw::frontend {
namespace {

constexpr int kRadius = 5;
constexpr int kSide = 2 * kRadius + 1;
constexpr int kMargin = 4;              // px that the fit may reach beyond the right patch
constexpr float kSigma = 3;             // px, of the weights about the centre
constexpr float kMaxCoordinate = 1e6f;  // px; beyond, and for NaN, nothing is looked at
constexpr float kMaxShift = 2.5f;       // px from the estimate
constexpr float kSettled = 0.01f;
constexpr int kMaxIterations = 10;
constexpr float kMinGradient = 1;  // grey values per px, root of the weighted mean square
// Slants are held to zero as by this share of the evidence for the shift: only where nothing in
// the patch tells of them does it matter.
constexpr float kSlantPrior = 0.08f;

// One value per column of the patch, and one more that counts nothing: vectors of whole registers.
using Lanes = Eigen::Array<float, kSide + 1, 1>;
using Patch = std::array<Lanes, kSide>;

// Unknowns: shift and brightness, then the shift's slope along the row and across it.
using Unknowns = Eigen::Vector4f;

struct Kernel {
  Lanes offset, weight;  // of a column, px from the centre
  float sum_of_weights;  // of the whole patch
};

const Kernel& Columns() {
  static const Kernel columns = [] {
    Kernel k;
    k.offset = Lanes::LinSpaced(static_cast<float>(-kRadius), static_cast<float>(kRadius + 1));
    k.weight = (-k.offset.square() / (2 * kSigma * kSigma)).exp();
    k.weight[kSide] = 0;
    k.sum_of_weights = 0;
    for (int j = 0; j < kSide; ++j) k.sum_of_weights += k.weight[j] * k.weight.sum();
    return k;
  }();
  return columns;
}

// A row of the image at y + fy, linear between rows.
template <size_t kCount>
void SampleRow(const ImageBuffer& image, int x, int y, float fy, std::array<float, kCount>* out) {
  const uint8_t* above = image.row(y) + x;
  const uint8_t* below = image.row(y + 1) + x;
  for (size_t i = 0; i < kCount; ++i) {
    const auto a = static_cast<float>(above[i]);
    (*out)[i] = a + fy * (static_cast<float>(below[i]) - a);
  }
}

bool Inside(const ImageBuffer& image, int x_begin, int x_end, int y_begin, int y_end) {
  return x_begin >= 0 && y_begin >= 0 && x_end <= image.width && y_end <= image.height;
}

}  // namespace

std::optional<float> RefineDisparity(const ImageBuffer& left, const ImageBuffer& right, float u,
                                     float v, float disparity) {
  constexpr int kStrip = kSide + 2 * kMargin + 1;
  const float u_right = u - disparity;
  if (!(std::abs(u) < kMaxCoordinate && std::abs(v) < kMaxCoordinate &&
        std::abs(u_right) < kMaxCoordinate)) {
    return std::nullopt;
  }
  const int x = static_cast<int>(std::floor(u));
  const int y = static_cast<int>(std::floor(v));
  const int x_right = static_cast<int>(std::floor(u_right));
  const float fx = u - static_cast<float>(x);
  const float fy = v - static_cast<float>(y);
  const int top = y - kRadius;
  const int strip_begin = x_right - kRadius - kMargin;
  if (!Inside(left, x - kRadius - 1, x + kRadius + 4, top, y + kRadius + 2) ||
      !Inside(right, strip_begin, strip_begin + kStrip, top, y + kRadius + 2)) {
    return std::nullopt;
  }

  // The left patch and its gradient along the row: what a shift changes. Taken from the left image
  // alone, so that the noise of the right one cannot draw the fit to where interpolation blurs it.
  const auto& [offset, weight, sum_of_weights] = Columns();
  Patch patch;
  Patch gradient;
  std::array<std::array<float, kStrip>, kSide> strip;
  Lanes g = Lanes::Zero(), gj = Lanes::Zero(), gg = Lanes::Zero(), ggj = Lanes::Zero(),
        ggjj = Lanes::Zero();
  for (int j = 0; j < kSide; ++j) {
    std::array<float, kSide + 4> row;
    SampleRow(left, x - kRadius - 1, top + j, fy, &row);
    SampleRow(right, strip_begin, top + j, fy, &strip[j]);
    const Eigen::Map<const Lanes> before(&row[0]), at(&row[1]), after(&row[2]), next(&row[3]);
    patch[j] = at + fx * (after - at);
    gradient[j] = 0.5f * ((after - before) + fx * ((next - at) - (after - before)));
    const float w = weight[j];
    const float dj = offset[j];
    const Lanes wg = w * weight * gradient[j];
    const Lanes wgg = wg * gradient[j];
    g += wg;
    gj += dj * wg;
    gg += wgg;
    ggj += dj * wgg;
    ggjj += dj * dj * wgg;
  }
  const float h02 = (gg * offset).sum();
  const float h12 = (g * offset).sum();
  const float h23 = (ggj * offset).sum();
  Eigen::Matrix4f H;
  H << gg.sum(), g.sum(), h02, ggj.sum(),           //
      g.sum(), sum_of_weights, h12, gj.sum(),       //
      h02, h12, (gg * offset.square()).sum(), h23,  //
      ggj.sum(), gj.sum(), h23, ggjj.sum();
  if (H(0, 0) < kMinGradient * kMinGradient * H(1, 1)) return std::nullopt;
  H(2, 2) += kSlantPrior * H(0, 0);
  H(3, 3) += kSlantPrior * H(0, 0);
  const Eigen::LDLT<Eigen::Matrix4f> solver(H);

  Unknowns p = Unknowns::Zero();
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const float stretch = 1 + p[2];
    Lanes r1 = Lanes::Zero(), rg = Lanes::Zero(), rgj = Lanes::Zero();
    for (int j = 0; j < kSide; ++j) {
      const float dj = offset[j];
      // In the strip; the right patch's first sample.
      const float begin = u_right - static_cast<float>(strip_begin) + p[0] + p[3] * dj -
                          stretch * static_cast<float>(kRadius);
      const float end = begin + stretch * static_cast<float>(kSide - 1);
      if (!(begin >= 0 && end >= 0 && begin < kStrip - 1 && end < kStrip - 1)) return std::nullopt;
      Lanes value = Lanes::Zero();
      for (int i = 0; i < kSide; ++i) {
        const float at = begin + stretch * static_cast<float>(i);
        const int k = static_cast<int>(at);
        value[i] = strip[j][k] + (at - static_cast<float>(k)) * (strip[j][k + 1] - strip[j][k]);
      }
      const Lanes r = weight[j] * weight * (value + p[1] - patch[j]);
      r1 += r;
      rg += r * gradient[j];
      rgj += dj * r * gradient[j];
    }
    Unknowns b(rg.sum(), r1.sum(), (rg * offset).sum(), rgj.sum());
    b[2] += kSlantPrior * H(0, 0) * p[2];
    b[3] += kSlantPrior * H(0, 0) * p[3];
    const Unknowns step = solver.solve(b);
    p -= step;
    if (!(std::abs(p[0]) <= kMaxShift)) return std::nullopt;
    if (std::abs(step[0]) < kSettled) return disparity - p[0];
  }
  return std::nullopt;
}

}  // namespace gw::frontend
