// Which covisible keyframes local bundle adjustment moves, when it may not move them all: the
// subgraph of the asked size whose poses are best determined (docs/method.md, section 6.4). After
// Y. Zhao, J. S. Smith, P. A. Vela, "Good Graph to Optimize: Cost-Effective, Budget-Aware Bundle
// Adjustment in Visual SLAM", arXiv 2008.10123.
//
//   choose S, |S| = size, newest in S, that maximises logdet( M_SS )
//   M = H_pp - H_pl inv(H_ll) H_lp
//
// the information of the poses of a pool with the landmarks marginalised; what the pool does not
// choose stays fixed, so that the problem that is solved has the principal submatrix M_SS. Greedy:
// each step takes the keyframe that raises the determinant most, from a block Cholesky
// factorisation that grows by the chosen block. The pool is small enough to look at every candidate
// in every step, which keeps 1 - 1/e of the best value without drawing a sample.
#pragma once

#include <Eigen/Core>
#include <set>
#include <vector>

#include "backend/core/map/map.h"
#include "backend/core/map/mapping_context.h"

namespace gw::backend {

inline constexpr size_t kGoodGraphPool = 60;  // keyframes, as in the paper named above

// The newest keyframe and the chosen of its covisible ones, config.local_keyframes in all. The
// whole pool when it is not larger.
std::set<KeyframeId> GoodGraphWindow(const Map& map, const MappingContext& context);

// M of the keyframes, 6 x 6 per keyframe in their order, at the map's poses and landmarks.
// Observations by keyframes that are not in `keyframes` hold the landmarks like fixed ones.
Eigen::MatrixXd MarginalInformation(const Map& map, const MappingContext& context,
                                    const std::vector<KeyframeId>& keyframes);

// Indices of `size` 6 x 6 blocks of M, the first always among them, in the order in which they were
// chosen. Precondition: M is positive semi-definite; 1 <= size <= its blocks.
std::vector<int> ChooseLargestLogdet(const Eigen::MatrixXd& M, int size);

}  // namespace gw::backend
