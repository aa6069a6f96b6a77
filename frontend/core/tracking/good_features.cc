#include "frontend/core/tracking/good_features.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "common/core/random.h"
#include "common/vision/reprojection.h"

namespace gw::frontend {
namespace {

// Sample per choice: ln(1 / epsilon) times candidates over choices, epsilon = 0.1, keeps 1 - 1/e -
// epsilon of the best value in expectation (Mirzasoleiman et al., AAAI 2015, theorem 1).
constexpr double kSampleFactor = 2.302585;
constexpr double kNothingKnown = 1e-5;  // information that makes the first determinants finite
constexpr uint64_t kStream = 0x6766;    // of random draws

// The 21 numbers of a symmetric matrix; off-diagonal ones doubled in one of two factors, so that
// the product of the two vectors is the trace of the product of the matrices.
using Packed = Eigen::Matrix<float, 21, 1>;

Packed Pack(const Matrix6d& m, double off_diagonal) {
  Packed out;
  int k = 0;
  for (int i = 0; i < 6; ++i) {
    out[k++] = static_cast<float>(m(i, i));
    for (int j = i + 1; j < 6; ++j) out[k++] = static_cast<float>(off_diagonal * m(i, j));
  }
  return out;
}

void TakeOut(std::vector<int>* open, size_t at) {
  (*open)[at] = open->back();
  open->pop_back();
}

std::vector<int> ChooseRandom(int count, uint64_t seed, std::vector<int>* open) {
  CounterRng rng(seed, kStream, 1);
  std::vector<int> chosen;
  while (static_cast<int>(chosen.size()) < count && !open->empty()) {
    const size_t at = rng.Below(static_cast<uint32_t>(open->size()));
    chosen.push_back((*open)[at]);
    TakeOut(open, at);
  }
  return chosen;
}

// J' J of a landmark that should appear as `expected`.
Matrix6d InformationOf(const RectifiedCamera& camera, const Pyramid& pyramid,
                       const Projection& expected) {
  PixelObservation pixel;
  pixel.u = expected.uv.x();
  pixel.v = expected.uv.y();
  pixel.disparity = camera.bf() / expected.p_C.z();
  pixel.has_depth = expected.p_C.z() < camera.depth_max_m;
  pixel.inverse_sigma = 1.0 / pyramid.Scale(expected.level);
  pixel.inverse_sigma_disparity =
      1.0 / DisparitySigma(camera, pyramid, expected.level, pixel.disparity);
  const auto J = PoseJacobian(ReprojectionJacobian(camera, pixel, expected.p_C), expected.p_C);
  return J.transpose() * J;
}

}  // namespace

std::vector<int> ChooseGood(const std::vector<Matrix6d>& information, int count, uint64_t seed,
                            std::vector<int>* open, Matrix6d* H, int64_t* evaluations) {
  std::vector<int> chosen;
  std::vector<Packed> packed(information.size());
  for (const int i : *open) packed[i] = Pack(information[i], 2.0);
  CounterRng rng(seed, kStream, 0);
  const auto sample = static_cast<int>(
      std::ceil(kSampleFactor * static_cast<double>(open->size()) / std::max(1, count)));
  while (static_cast<int>(chosen.size()) < count && !open->empty()) {
    const Packed inverse = Pack(H->llt().solve(Matrix6d::Identity()), 1.0);
    size_t best = 0;
    float most = -1;
    for (int draw = 0; draw < sample; ++draw) {
      const size_t at = rng.Below(static_cast<uint32_t>(open->size()));
      const float worth = inverse.dot(packed[(*open)[at]]);
      if (worth <= most) continue;
      most = worth;
      best = at;
    }
    *evaluations += sample;
    chosen.push_back((*open)[best]);
    *H += information[(*open)[best]];
    TakeOut(open, best);
  }
  return chosen;
}

ChoiceResult GoodFeatures::Match(const ProjectionMatcher& matcher, const SE3& T_WC,
                                 const std::vector<Candidate>& candidates, int first_index,
                                 const SearchableImage& image, const MatcherLimits& limits,
                                 const Choice& choice, std::vector<int>* match) const {
  ChoiceResult out;
  const SE3 T_CW = T_WC.inverse();
  std::vector<int> open;
  std::vector<Matrix6d> information(candidates.size());
  const bool good = choice.matching == Matching::kGood;
  for (size_t c = 0; c < candidates.size(); ++c) {
    const auto expected = matcher.Expect(candidates[c], T_WC, T_CW);
    if (!expected) continue;
    if (good) information[c] = InformationOf(camera_, pyramid_, *expected);
    open.push_back(static_cast<int>(c));
  }
  out.in_view = static_cast<int>(open.size());
  Matrix6d found = choice.known + kNothingKnown * Matrix6d::Identity();
  for (int round = 0; round < kRounds && out.matched < choice.budget && !open.empty(); ++round) {
    const int wanted = choice.budget - out.matched;
    std::vector<int> chosen;
    if (static_cast<int>(open.size()) <= wanted) {
      std::swap(chosen, open);
    } else if (good) {
      Matrix6d H = found;
      chosen = ChooseGood(information, wanted, choice.seed + static_cast<uint64_t>(round), &open,
                          &H, &out.evaluations);
    } else {
      chosen = ChooseRandom(wanted, choice.seed + static_cast<uint64_t>(round), &open);
    }
    std::vector<Candidate> batch;
    batch.reserve(chosen.size());
    for (const int c : chosen) batch.push_back(candidates[c]);
    const int begin = first_index + static_cast<int>(out.searched.size());
    out.matched += matcher.Match(T_WC, batch, begin, image, limits, match);
    out.searched.insert(out.searched.end(), batch.begin(), batch.end());
    if (!good) continue;
    for (const int m : *match) {
      if (m >= begin) found += information[chosen[m - begin]];
    }
  }
  return out;
}

}  // namespace gw::frontend
