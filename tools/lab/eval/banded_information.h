// The normal equations of a spline's control poses, and covariances from them. Inside of
// tools/lab/eval only.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "common/core/se3.h"

namespace gw::eval {

// A row of a Jacobian: `values` of the columns from `first` on, within four control poses of six
// columns each.
struct SparseRow {
  size_t first = 0;
  std::span<const double> values;
};

// Block tridiagonal, in blocks of three control poses: what four neighbouring control poses share
// lies in two neighbouring blocks.
class BandedInformation {
 public:
  explicit BandedInformation(size_t controls);

  // Adds weight * row^T row.
  void Add(const SparseRow& row, double weight);
  // After all rows, before Covariance. Precondition: positive definite.
  void Factor();
  // J inv(information) J^T of six rows, all within the same four control poses.
  Matrix6d Covariance(const std::array<SparseRow, 6>& rows) const;

 private:
  static constexpr Eigen::Index kBlock = 18;
  using Block = Eigen::Matrix<double, kBlock, kBlock>;

  std::vector<Block> diagonal_;
  std::vector<Block> above_;  // above_[i]: between block i and i + 1
  // Information that block i has of itself and all before it, and of itself and all after it.
  std::vector<Block> forward_, backward_;
};

}  // namespace gw::eval
