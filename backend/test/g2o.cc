#include "backend/test/g2o.h"

#include <Eigen/Cholesky>
#include <fstream>
#include <map>
#include <sstream>

namespace gw::backend {
namespace {

// d(our rotation vector) = 2 d(vector part).
constexpr double kVectorPart = 0.5;

SE3 ReadPose(std::istringstream& fields) {
  double x = 0, y = 0, z = 0, qx = 0, qy = 0, qz = 0, qw = 1;
  fields >> x >> y >> z >> qx >> qy >> qz >> qw;
  return SE3(Eigen::Quaterniond(qw, qx, qy, qz), {x, y, z});
}

}  // namespace

Result<PoseGraph> ReadG2o(const std::string& path) {
  std::ifstream in(path);
  if (!in) return Error{ErrorCode::kNotFound, path + ": cannot be opened"};
  PoseGraph graph;
  std::map<int64_t, int32_t> index;
  int line_number = 0;
  for (std::string line; std::getline(in, line);) {
    ++line_number;
    std::istringstream fields(line);
    std::string tag;
    fields >> tag;
    const auto bad = [&](const char* what) {
      return Error{ErrorCode::kBadData, path + ":" + std::to_string(line_number) + ": " + what};
    };
    if (tag == "VERTEX_SE3:QUAT") {
      int64_t id = 0;
      fields >> id;
      const SE3 T = ReadPose(fields);
      if (!fields || !T.IsFinite()) return bad("a vertex needs id, x y z, qx qy qz qw");
      index[id] = static_cast<int32_t>(graph.nodes.size());
      graph.nodes.push_back({T, graph.nodes.empty()});
    } else if (tag == "EDGE_SE3:QUAT") {
      int64_t from = 0, to = 0;
      fields >> from >> to;
      PoseGraph::Edge edge;
      edge.T_FromTo = ReadPose(fields);
      Matrix6d information;
      for (int r = 0; r < 6; ++r) {
        for (int c = r; c < 6; ++c) fields >> information(r, c);
      }
      if (!fields || !index.contains(from) || !index.contains(to)) {
        return bad("an edge needs two known vertices, a pose and 21 numbers");
      }
      for (int r = 0; r < 6; ++r) {
        for (int c = 0; c < r; ++c) information(r, c) = information(c, r);
      }
      Vector6d scale;
      scale << 1, 1, 1, kVectorPart, kVectorPart, kVectorPart;
      information = scale.asDiagonal() * information * scale.asDiagonal();
      edge.from = index[from];
      edge.to = index[to];
      edge.sqrt_information = Eigen::LLT<Matrix6d>(information).matrixU();
      graph.edges.push_back(edge);
    }
  }
  return graph;
}

double G2oCost(const PoseGraph& graph, const std::vector<SE3>& T_WC) {
  double cost = 0;
  for (const auto& edge : graph.edges) {
    const SE3 E = edge.T_FromTo.inverse() * T_WC[edge.from].inverse() * T_WC[edge.to];
    const double sign = E.rotation().w() < 0 ? -1 : 1;
    Vector6d e;
    e << E.translation(), sign / kVectorPart * E.rotation().vec();
    cost += (edge.sqrt_information * e).squaredNorm();
  }
  return cost;
}

}  // namespace gw::backend
