#include "frontend/core/features/disparity_refiner.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstring>

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
void SampleRow(const ImageBuffer& image, int x, int y, float fy, float* out) {
  const uint8_t* above = image.row(y) + x;
  const uint8_t* below = image.row(y + 1) + x;
  for (size_t i = 0; i < kCount; ++i) {
    const auto a = static_cast<float>(above[i]);
    out[i] = a + fy * (static_cast<float>(below[i]) - a);
  }
}

bool Inside(const ImageBuffer& image, int x_begin, int x_end, int y_begin, int y_end) {
  return x_begin >= 0 && y_begin >= 0 && x_end <= image.width && y_end <= image.height;
}

constexpr int kStrip = kSide + 2 * kMargin + 1;
// A row of the right image. Vectors of whole registers also read zeros before it and behind it.
constexpr int kBefore = 1;
constexpr int kBehind = 4;
using StripRow = std::array<float, kBefore + kStrip + kBehind>;
using Strip = std::array<StripRow, kSide>;

// The left patch and its gradient along the row: what a shift changes. Taken from the left image
// alone, so that the noise of the right one cannot draw the fit to where interpolation blurs it.
struct LeftPatch {
  Patch value, gradient;
  Eigen::Matrix4f H;  // normal equations of the fit, its prior included
};

// Where a patch lies in an image: its centre is (x + fx, y + fy).
struct Corner {
  int x, y;
  float fx, fy;
};

LeftPatch Linearize(const ImageBuffer& left, const Corner& c) {
  const auto& [offset, weight, sum_of_weights] = Columns();
  LeftPatch out;
  Lanes g = Lanes::Zero(), gj = Lanes::Zero(), gg = Lanes::Zero(), ggj = Lanes::Zero(),
        ggjj = Lanes::Zero();
  for (int j = 0; j < kSide; ++j) {
    std::array<float, kSide + 4> row;
    SampleRow<kSide + 4>(left, c.x - kRadius - 1, c.y - kRadius + j, c.fy, row.data());
    const Eigen::Map<const Lanes> before(&row[0]), at(&row[1]), after(&row[2]), next(&row[3]);
    out.value[j] = at + c.fx * (after - at);
    out.gradient[j] = 0.5f * ((after - before) + c.fx * ((next - at) - (after - before)));
    const float w = weight[j];
    const float dj = offset[j];
    const Lanes wg = w * weight * out.gradient[j];
    const Lanes wgg = wg * out.gradient[j];
    g += wg;
    gj += dj * wg;
    gg += wgg;
    ggj += dj * wgg;
    ggjj += dj * dj * wgg;
  }
  const float h02 = (gg * offset).sum();
  const float h12 = (g * offset).sum();
  const float h23 = (ggj * offset).sum();
  out.H << gg.sum(), g.sum(), h02, ggj.sum(),       //
      g.sum(), sum_of_weights, h12, gj.sum(),       //
      h02, h12, (gg * offset.square()).sum(), h23,  //
      ggj.sum(), gj.sum(), h23, ggjj.sum();
  return out;
}

// Four neighbouring columns.
using Four [[gnu::vector_size(16)]] = float;
using FourInts [[gnu::vector_size(16)]] = int;

Four LoadFour(const float* p) {
  Four out;
  std::memcpy(&out, p, sizeof(out));
  return out;
}

// The row at begin, begin + stretch, ..., linear between pixels. Preconditions: the first and the
// last of the kSide places lie on the strip.
Lanes SampleAlong(const StripRow& row, float begin, float stretch) {
  const float* const pixels = row.data() + kBefore;
  Lanes out = Lanes::Zero();
  if (!(std::abs(stretch - 1) * kSide < 1)) {
    for (int i = 0; i < kSide; ++i) {
      const float at = begin + stretch * static_cast<float>(i);
      const int k = static_cast<int>(at);
      out[i] = pixels[k] + (at - static_cast<float>(k)) * (pixels[k + 1] - pixels[k]);
    }
    return out;
  }
  // Column i falls between the pixels first + i and its neighbour, or one pixel beside: no look-up
  // by column is needed, but a choice of three.
  const int first = static_cast<int>(begin);
  for (int i = 0; i < kSide; i += 4) {
    const FourInts column = FourInts{0, 1, 2, 3} + i;
    const Four at = begin + stretch * __builtin_convertvector(column, Four);
    const FourInts k = __builtin_convertvector(at, FourInts);
    const FourInts beside = k - first - column;
    const float* const p = pixels + first + i;
    const Four a = LoadFour(p - 1);
    const Four b = LoadFour(p);
    const Four c = LoadFour(p + 1);
    const Four d = LoadFour(p + 2);
    const Four before = beside < 0 ? a : beside > 0 ? c : b;
    const Four after = beside < 0 ? b : beside > 0 ? d : c;
    const Four value = before + (at - __builtin_convertvector(k, Four)) * (after - before);
    std::memcpy(out.data() + i, &value, sizeof(value));
  }
  return out;
}

// Gauss-Newton on shift, brightness and slants (Unknowns). first: where the right patch begins in
// the strip. The shift, or none where the fit does not settle.
std::optional<float> Fit(const LeftPatch& patch, const Strip& strip, float first) {
  const auto& [offset, weight, sum_of_weights] = Columns();
  const float prior = kSlantPrior * patch.H(0, 0);
  Eigen::Matrix4f H = patch.H;
  H(2, 2) += prior;
  H(3, 3) += prior;
  const Eigen::LDLT<Eigen::Matrix4f> solver(H);
  Unknowns p = Unknowns::Zero();
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const float stretch = 1 + p[2];
    Lanes r1 = Lanes::Zero(), rg = Lanes::Zero(), rgj = Lanes::Zero();
    for (int j = 0; j < kSide; ++j) {
      const float dj = offset[j];
      // In the strip; the right patch's first sample.
      const float begin = first + p[0] + p[3] * dj - stretch * static_cast<float>(kRadius);
      const float end = begin + stretch * static_cast<float>(kSide - 1);
      if (!(begin >= 0 && end >= 0 && begin < kStrip - 1 && end < kStrip - 1)) return std::nullopt;
      const Lanes value = SampleAlong(strip[j], begin, stretch);
      const Lanes r = weight[j] * weight * (value + p[1] - patch.value[j]);
      r1 += r;
      rg += r * patch.gradient[j];
      rgj += dj * r * patch.gradient[j];
    }
    Unknowns b(rg.sum(), r1.sum(), (rg * offset).sum(), rgj.sum());
    b[2] += prior * p[2];
    b[3] += prior * p[3];
    const Unknowns step = solver.solve(b);
    p -= step;
    if (!(std::abs(p[0]) <= kMaxShift)) return std::nullopt;
    if (std::abs(step[0]) < kSettled) return p[0];
  }
  return std::nullopt;
}

}  // namespace

std::optional<float> RefineDisparity(const ImageBuffer& left, const ImageBuffer& right, float u,
                                     float v, float disparity) {
  const float u_right = u - disparity;
  if (!(std::abs(u) < kMaxCoordinate && std::abs(v) < kMaxCoordinate &&
        std::abs(u_right) < kMaxCoordinate)) {
    return std::nullopt;
  }
  const int x = static_cast<int>(std::floor(u));
  const int y = static_cast<int>(std::floor(v));
  const int x_right = static_cast<int>(std::floor(u_right));
  const Corner corner{x, y, u - static_cast<float>(x), v - static_cast<float>(y)};
  const int top = y - kRadius;
  const int strip_begin = x_right - kRadius - kMargin;
  if (!Inside(left, x - kRadius - 1, x + kRadius + 4, top, y + kRadius + 2) ||
      !Inside(right, strip_begin, strip_begin + kStrip, top, y + kRadius + 2)) {
    return std::nullopt;
  }
  const LeftPatch patch = Linearize(left, corner);
  if (patch.H(0, 0) < kMinGradient * kMinGradient * patch.H(1, 1)) return std::nullopt;
  Strip strip{};
  for (int j = 0; j < kSide; ++j) {
    SampleRow<kStrip>(right, strip_begin, top + j, corner.fy, strip[j].data() + kBefore);
  }
  const auto shift = Fit(patch, strip, u_right - static_cast<float>(strip_begin));
  if (!shift) return std::nullopt;
  return disparity - *shift;
}

}  // namespace gw::frontend
