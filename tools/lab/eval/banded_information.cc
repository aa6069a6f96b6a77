#include "tools/lab/eval/banded_information.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace gw::eval {

BandedInformation::BandedInformation(size_t controls) {
  // A multiple of three control poses, at least two blocks; those that are none know themselves.
  const size_t blocks = std::max<size_t>(2, (controls + 2) / 3);
  diagonal_.assign(blocks, Block::Zero());
  above_.assign(blocks - 1, Block::Zero());
  for (size_t column = 6 * controls; column < 18 * blocks; ++column) {
    const auto i = static_cast<Eigen::Index>(column % 18);
    diagonal_[column / 18](i, i) = 1;
  }
}

void BandedInformation::Add(const SparseRow& row, double weight) {
  for (size_t a = 0; a < row.values.size(); ++a) {
    for (size_t b = 0; b < row.values.size(); ++b) {
      const size_t i = row.first + a, k = row.first + b;
      const double value = weight * row.values[a] * row.values[b];
      const auto r = static_cast<Eigen::Index>(i % 18), c = static_cast<Eigen::Index>(k % 18);
      if (i / 18 == k / 18) {
        diagonal_[i / 18](r, c) += value;
      } else if (i < k) {
        above_[i / 18](r, c) += value;
      }
    }
  }
}

void BandedInformation::Factor() {
  const size_t n = diagonal_.size();
  forward_ = backward_ = diagonal_;
  for (size_t i = 1; i < n; ++i) {
    const Block& U = above_[i - 1];
    forward_[i] -= U.transpose() * forward_[i - 1].ldlt().solve(U);
  }
  for (size_t i = n - 1; i-- > 0;) {
    const Block& U = above_[i];
    backward_[i] -= U * backward_[i + 1].ldlt().solve(U.transpose());
  }
}

Matrix6d BandedInformation::Covariance(const std::array<SparseRow, 6>& rows) const {
  size_t first = rows[0].first;
  for (const SparseRow& row : rows) first = std::min(first, row.first);
  const size_t block = std::min(first / 18, diagonal_.size() - 2);
  Eigen::Matrix<double, 2 * kBlock, 2 * kBlock> pair;
  pair << forward_[block], above_[block], above_[block].transpose(), backward_[block + 1];
  Eigen::Matrix<double, 2 * kBlock, 6> J = Eigen::Matrix<double, 2 * kBlock, 6>::Zero();
  for (size_t k = 0; k < 6; ++k) {
    for (size_t a = 0; a < rows[k].values.size(); ++a) {
      J(static_cast<Eigen::Index>(rows[k].first + a - 18 * block), static_cast<Eigen::Index>(k)) =
          rows[k].values[a];
    }
  }
  return J.transpose() * pair.ldlt().solve(J);
}

}  // namespace gw::eval
