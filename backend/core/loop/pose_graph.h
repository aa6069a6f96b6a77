// Pose-graph optimisation: keyframe poses that agree best with relative poses between them.
//
// Minimises sum over edges of w_g |S Log(inv(T_ab) inv(T_a) T_b)|^2 (S = sqrt_information; tangent
// [translation; rotation] on the right).
// Edges of one group (a loop closure and what hangs on it) share a switch w_g in {0, 1}, found by
// graduated non-convexity for truncated least squares (Yang, Antonante, Tzoumas, Carlone, RA-L
// 2020): a group whose edges cannot be reconciled with the rest is switched off. Edges of no group
// always count.
//
// Pure, single-threaded, bounded by iteration counts; same graph, same bytes.
#pragma once

#include <cstdint>
#include <vector>

#include "common/core/chi_square.h"
#include "common/core/se3.h"

namespace gw::backend {

struct PoseGraph {
  struct Node {
    SE3 T_WC;
    bool fixed = false;
  };
  struct Edge {
    int32_t from = 0, to = 0;  // indices into nodes
    SE3 T_FromTo;
    Matrix6d sqrt_information = Matrix6d::Identity();  // upper triangular
    int32_t group = -1;                                // -1: always counts
  };
  int iterations = 50;      // of each solve
  std::vector<Node> nodes;  // at least one is fixed
  std::vector<Edge> edges;
  int32_t num_groups = 0;
};

struct PoseGraphResult {
  bool usable = false;              // false: the solver failed, or the numbers are not finite
  std::vector<SE3> T_WC;            // one per node
  std::vector<uint8_t> group_kept;  // one per group: 1 kept, 0 switched off
  double cost_before = 0;           // half the sum of squares, of what is kept
  double cost_after = 0;
  int iterations = 0;  // over all solves
};

// A group is switched off when the mean squared residual of its edges stays above this.
inline constexpr double kGroupGate = kChi2Six999;

PoseGraphResult SolvePoseGraph(const PoseGraph& graph);

}  // namespace gw::backend
