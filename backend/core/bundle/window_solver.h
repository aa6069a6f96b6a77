// Bundle adjustment of a window: poses and landmarks that explain observations best, together with
// costs between poses.
//
// Levenberg-Marquardt (Madsen, Nielsen, Tingleff, "Methods for non-linear least squares problems",
// 2004, with the update of the damping of section 3.2) on iteratively reweighted normal equations,
// landmarks eliminated by the Schur complement (Triggs, McLauchlan, Hartley, Fitzgibbon, "Bundle
// adjustment - a modern synthesis", 2000, section 6.1). The reduced system of a window is nearly
// full and is solved densely, so that time grows with the cube of the number of free poses: meant
// for at most a hundred or so. Sizes of blocks are known at compile time, which makes it faster
// than a general solver (ADR 32). Deterministic; bounded by iteration counts only.
#pragma once

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>

#include <Eigen/Core>
#include <functional>
#include <span>
#include <vector>

#include "backend/core/bundle/ceres_blocks.h"
#include "common/camera/camera_model.h"
#include "common/vision/reprojection.h"

namespace gw::backend {

class WindowSolver {
 public:
  // A landmark as one pose sees it.
  struct Sight {
    int pose = 0;
    PixelObservation pixel;
  };
  struct Options {
    int iterations = 10;
    double function_tolerance = 1e-4;  // relative change of the cost that ends the solve
    std::function<bool()> stop;
  };
  struct Summary {
    // False: stopped, or an observation is not in front of its camera at the start, or a number is
    // not finite. The variables are then unspecified.
    bool usable = false;
    int iterations = 0;  // steps that were tried
  };

  explicit WindowSolver(const RectifiedCamera& camera) : camera_(camera) {}

  // All that is added must outlive the solver; variables are changed by Solve(). Poses come first,
  // then other variables, then costs. Each returns the number of the block.
  int AddPose(PoseBlock* T_WC, bool fixed);
  int AddVariable(double* values, int size);
  // The cost's parameters are these blocks, in its order. The loss may be null.
  void AddCost(const ceres::CostFunction* cost, const ceres::LossFunction* loss,
               std::vector<int> blocks);
  // Robust: Huber costs of pixel and depth apart (docs/method.md, section 2). Precondition: poses
  // in the order in which they were added, none twice.
  void AddLandmark(Eigen::Vector3d* p_W, std::span<const Sight> sights);

  Summary Solve(const Options& options);

 private:
  struct Block {
    double* values = nullptr;
    int ambient = 0;
    int tangent = 0;
    int column = -1;  // first in the reduced system; -1: fixed
  };
  struct Cost {
    const ceres::CostFunction* function;
    const ceres::LossFunction* loss;
    std::vector<int> blocks;
  };
  struct Landmark {
    Eigen::Vector3d* p_W;
    size_t begin, end;  // of sights_
  };
  // Normal equations before elimination, H d = b. A landmark's block of H is 3 x 3, a sight couples
  // its pose to its landmark.
  struct Point {
    Eigen::Matrix3d H;
    Eigen::Vector3d b;
  };
  using Coupling = Eigen::Matrix<double, 6, 3>;
  struct Camera {
    Eigen::Matrix3d R_CW;
    Eigen::Vector3d p_WC;
  };

  std::vector<Camera> Cameras() const;
  double CostOfSights() const;
  double CostOfCosts() const;
  double TotalCost() const { return CostOfSights() + CostOfCosts(); }
  void Linearize();
  void LinearizeSights();
  void LinearizeCost(const Cost& cost);
  void Eliminate(double damping);
  bool SolveReduced();
  double BackSubstitute(double damping);  // the decrease of the cost that the linear model expects
  void Move();
  void Save();
  void Restore();

  RectifiedCamera camera_;
  std::vector<Block> blocks_;
  std::vector<Cost> costs_;
  std::vector<Landmark> landmarks_;
  std::vector<Sight> sights_;
  int columns_ = 0;
  int free_poses_ = 0;

  Eigen::MatrixXd H_;  // of poses and other variables, lower triangle
  Eigen::VectorXd b_;
  std::vector<Point> points_;
  std::vector<Coupling> couplings_;  // one per sight
  Eigen::MatrixXd reduced_;
  std::vector<Matrix6d> eliminated_;  // between free poses i >= j at i (i + 1) / 2 + j
  Eigen::VectorXd reduced_b_;
  Eigen::VectorXd step_;
  std::vector<Eigen::Vector3d> point_steps_;
  std::vector<double> saved_;
};

}  // namespace gw::backend
