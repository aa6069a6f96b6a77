#include "backend/core/bundle/good_graph.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <map>

#include "backend/core/map/seen_landmarks.h"
#include "common/vision/reprojection.h"

namespace gw::backend {
namespace {

constexpr int kFewestNeighbours = 3;  // taken even below the covisibility threshold
// Information per m and rad that keeps the factors finite where a pose is not determined at all.
constexpr double kNothingKnown = 1e-5;

std::vector<KeyframeId> Pool(const Map& map, const MappingContext& context) {
  std::vector<KeyframeId> pool{map.newest_keyframe()};
  for (const auto& [id, shared] : map.Neighbours(map.newest_keyframe(), 1)) {
    if (pool.size() >= kGoodGraphPool) break;
    if (shared < context.config.covisibility_min_shared && pool.size() > kFewestNeighbours) break;
    pool.push_back(id);
  }
  return pool;
}

using PoseRows = Eigen::Matrix<double, 3, 6>;

// What one landmark tells of the poses that see it.
class LandmarkBlock {
 public:
  // block: of the pose, or -1 for a fixed one.
  void Add(const MappingContext& context, const PixelObservation& pixel, const SE3& T_CW,
           const Eigen::Vector3d& p_W, int block) {
    const Eigen::Vector3d p_C = T_CW * p_W;
    if (!(p_C.z() > kMinProjectionDepth)) return;
    const Eigen::Matrix3d J_C = ReprojectionJacobian(context.camera, pixel, p_C);
    const Eigen::Matrix3d J_W = J_C * T_CW.rotation().toRotationMatrix();
    H_ll_ += J_W.transpose() * J_W;
    if (block < 0) return;
    const PoseRows J_T = PoseJacobian(J_C, p_C);
    poses_.push_back({block, J_T.transpose() * J_T, J_T.transpose() * J_W});
  }

  // Into the lower triangle of M.
  void Marginalise(Eigen::MatrixXd* M) const {
    const Eigen::Matrix3d inverse = (H_ll_ + kNothingKnown * Eigen::Matrix3d::Identity()).inverse();
    for (const Pose& a : poses_) {
      M->block<6, 6>(6 * a.block, 6 * a.block) += a.H_pp;
      const Eigen::Matrix<double, 6, 3> scaled = a.H_pl * inverse;
      for (const Pose& b : poses_) {
        if (b.block > a.block) continue;
        M->block<6, 6>(6 * a.block, 6 * b.block) -= scaled * b.H_pl.transpose();
      }
    }
  }

 private:
  struct Pose {
    int block;
    Matrix6d H_pp;
    Eigen::Matrix<double, 6, 3> H_pl;
  };
  Eigen::Matrix3d H_ll_ = Eigen::Matrix3d::Zero();
  std::vector<Pose> poses_;
};

}  // namespace

Eigen::MatrixXd MarginalInformation(const Map& map, const MappingContext& context,
                                    const std::vector<KeyframeId>& keyframes) {
  const auto n = static_cast<Eigen::Index>(6 * keyframes.size());
  std::map<KeyframeId, int> block;
  std::map<KeyframeId, SE3> T_CW;
  Eigen::MatrixXd M = kNothingKnown * Eigen::MatrixXd::Identity(n, n);
  for (size_t i = 0; i < keyframes.size(); ++i) block[keyframes[i]] = static_cast<int>(i);
  for (const LandmarkId id : SeenLandmarks(map, keyframes)) {
    const Landmark& landmark = *map.FindLandmark(id);
    if (landmark.observations.size() < 2) continue;
    LandmarkBlock of_landmark;
    for (const Observation& o : landmark.observations) {
      const Keyframe& frame = map.FindKeyframe(o.keyframe)->frame;
      const auto feature = static_cast<size_t>(o.feature_index);
      if (feature >= frame.features.size()) continue;
      auto pose = T_CW.find(o.keyframe);
      if (pose == T_CW.end()) pose = T_CW.emplace(o.keyframe, frame.T_WC.inverse()).first;
      const auto at = block.find(o.keyframe);
      const double z = (pose->second * landmark.p_W).z();
      of_landmark.Add(context,
                      ObservationOf(frame.features[feature], context.camera, context.pyramid, z),
                      pose->second, landmark.p_W, at == block.end() ? -1 : at->second);
    }
    of_landmark.Marginalise(&M);
  }
  return M.selfadjointView<Eigen::Lower>();
}

std::vector<int> ChooseLargestLogdet(const Eigen::MatrixXd& M, int size) {
  const auto blocks = static_cast<int>(M.rows() / 6);
  // For every candidate i: W_i = inv(L) M_Si, and what is left of M_ii without the chosen ones, D_i
  // = M_ii - W_i' W_i, the square of its block on the diagonal of the factor.
  std::vector<Eigen::MatrixXd> W(static_cast<size_t>(blocks), Eigen::MatrixXd(6 * size, 6));
  std::vector<Matrix6d> D(static_cast<size_t>(blocks));
  std::vector<int> open;
  for (int i = 0; i < blocks; ++i) {
    D[i] = M.block<6, 6>(6 * i, 6 * i);
    open.push_back(i);
  }
  std::vector<int> chosen;
  while (static_cast<int>(chosen.size()) < size) {
    size_t best = 0;
    double most = 0;
    for (size_t c = 0; c < open.size(); ++c) {
      const double determinant = D[open[c]].determinant();
      if (c > 0 && (determinant <= most || chosen.empty())) continue;
      most = determinant;
      best = c;
    }
    const int j = open[best];
    open.erase(open.begin() + static_cast<std::ptrdiff_t>(best));
    const auto known = static_cast<Eigen::Index>(6 * chosen.size());
    chosen.push_back(j);
    const Eigen::LLT<Matrix6d> factor(D[j]);
    for (const int i : open) {
      const Matrix6d rest =
          M.block<6, 6>(6 * j, 6 * i) - W[j].topRows(known).transpose() * W[i].topRows(known);
      const Matrix6d row = factor.matrixL().solve(rest);
      W[i].middleRows<6>(known) = row;
      D[i] -= row.transpose() * row;
    }
  }
  return chosen;
}

std::set<KeyframeId> GoodGraphWindow(const Map& map, const MappingContext& context) {
  const std::vector<KeyframeId> pool = Pool(map, context);
  const auto size = static_cast<size_t>(context.config.local_keyframes);
  if (pool.size() <= size) return {pool.begin(), pool.end()};
  std::set<KeyframeId> out;
  for (const int i : ChooseLargestLogdet(MarginalInformation(map, context, pool),
                                         context.config.local_keyframes)) {
    out.insert(pool[static_cast<size_t>(i)]);
  }
  return out;
}

}  // namespace gw::backend
