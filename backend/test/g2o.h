// Pose graphs in g2o's text format (VERTEX_SE3:QUAT, EDGE_SE3:QUAT), for tests of the optimiser.
#pragma once

#include <string>

#include "backend/core/loop/pose_graph.h"
#include "common/core/result.h"

namespace gw::backend {

// The information matrices of the format belong to the error (translation, vector part of the
// quaternion) of inv(T_FromTo) * inv(T_from) * T_to; the vector part is half our rotation vector to
// first order, and sqrt_information is for ours. The first vertex is fixed.
// Errors: kNotFound; kBadData with file:line.
Result<PoseGraph> ReadG2o(const std::string& path);

// The cost as g2o counts it (sum of e^T information e, with e as above and the information that
// belongs to sqrt_information), of other poses of the same graph.
double G2oCost(const PoseGraph& graph, const std::vector<SE3>& T_WC);

}  // namespace gw::backend
