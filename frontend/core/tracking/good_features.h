// Which landmarks are worth looking for: those that together tell most of the pose, within a budget
// of matches (docs/method.md, section 5.12). After Y. Zhao and P. A. Vela, "Good Feature Matching:
// Toward Accurate, Robust VO/VSLAM With Low Latency", IEEE T-RO 36(3), 2020.
//
//   choose S, |S| <= budget, that maximises logdet( H_0 + sum over S of J_i' J_i )
//
// J_i: derivative of the landmark's residuals by the pose, whitened by the pixel sigma of the level
// at which it should show. Greedy, each time among a random part of the candidates ("lazier than
// lazy greedy": Mirzasoleiman et al., AAAI 2015), by the derivative tr( inv(H) J_i' J_i ) of the
// determinant's logarithm, which a landmark changes little once H holds a few tens of them. Chosen
// landmarks are matched in a batch; those that are not found are replaced in the next, at most
// kRounds times. Work is counted, not timed: the same input gives the same choice.
#pragma once

#include <cstdint>
#include <vector>

#include "common/camera/camera_model.h"
#include "common/config/frontend_config.h"
#include "common/core/se3.h"
#include "common/vision/pyramid.h"
#include "frontend/core/map/projection_matcher.h"

namespace gw::frontend {

// What is to be chosen.
struct Choice {
  Matching matching = Matching::kGood;  // kGood or kRandom
  int budget = 0;                       // matches
  uint64_t seed = 0;                    // of the image
  Matrix6d known = Matrix6d::Zero();    // H_0: information of the pose without the candidates
};

// What became of it.
struct ChoiceResult {
  std::vector<Candidate> searched;  // `match` refers to these, in this order
  int in_view = 0;                  // candidates that should be in the image
  int matched = 0;
  int64_t evaluations = 0;  // of a candidate's worth
};

class GoodFeatures {
 public:
  static constexpr int kRounds = 4;

  GoodFeatures(const RectifiedCamera& camera, const Pyramid& pyramid)
      : camera_(camera), pyramid_(pyramid) {}

  // As ProjectionMatcher::Match, but of the candidates only a choice. match[i] becomes the index
  // into ChoiceResult::searched, plus first_index.
  ChoiceResult Match(const ProjectionMatcher& matcher, const SE3& T_WC,
                     const std::vector<Candidate>& candidates, int first_index,
                     const SearchableImage& image, const MatcherLimits& limits,
                     const Choice& choice, std::vector<int>* match) const;

 private:
  RectifiedCamera camera_;
  Pyramid pyramid_;
};

// Adds up to `count` indices of `open` to the result, and takes them out of `open`, which changes
// its order. information: J' J of each candidate. H: information of the pose so far, positive
// definite; the chosen ones are added to it. evaluations: counted up.
std::vector<int> ChooseGood(const std::vector<Matrix6d>& information, int count, uint64_t seed,
                            std::vector<int>* open, Matrix6d* H, int64_t* evaluations);

}  // namespace gw::frontend
