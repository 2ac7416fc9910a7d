// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/extended_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <limits>
#include <numeric>
#include <random>

namespace hybrid {
namespace {

/// A sparse Jacobian in the layout of the solvers.
struct System {
  ResidualLayout layout;
  std::vector<double> J;
  std::vector<int> starts;

  explicit System(std::vector<int> dims) {
    layout.dims = std::move(dims);
    int start = 0;
    for (int dim : layout.dims) {
      starts.push_back(start);
      start += dim;
    }
    starts.push_back(start);
  }
  void add(const std::vector<int>& blocks, const std::vector<Eigen::MatrixXd>& parts,
           bool coupled = true) {
    layout.add(static_cast<int>(parts[0].rows()), blocks.data(), static_cast<int>(blocks.size()),
               coupled);
    for (const Eigen::MatrixXd& part : parts) {
      J.insert(J.end(), part.data(), part.data() + part.size());
    }
  }
  /// One residual per block where it is not coupled.
  Eigen::MatrixXd dense() const {
    Eigen::MatrixXd all(0, starts.back());
    for (const auto& r : layout.residuals) {
      const double* entry = J.data() + r.jacobian;
      const int rows = static_cast<int>(all.rows());
      const int copies = r.coupled ? 1 : r.count;
      all.conservativeResize(rows + copies * r.rows, Eigen::NoChange);
      all.bottomRows(copies * r.rows).setZero();
      for (int i = 0; i < r.count; ++i) {
        const int b = layout.blocks[r.first + i];
        all.block(rows + (r.coupled ? 0 : i * r.rows), starts[b], r.rows, layout.dims[b]) =
            Eigen::Map<const Eigen::MatrixXd>(entry, r.rows, layout.dims[b]);
        entry += r.rows * layout.dims[b];
      }
    }
    return all;
  }
  ExtendedCholesky factor() const { return {layout, J.data()}; }
};

class RandomSystems {
 public:
  explicit RandomSystems(unsigned seed) : rng_(seed) {}

  int below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(rng_); }
  Eigen::MatrixXd matrix(int rows, int cols) {
    std::normal_distribution<double> normal;
    return Eigen::MatrixXd::NullaryExpr(rows, cols, [&] { return normal(rng_); });
  }
  /// Random dimensions and residuals; often too few of these, so that variables are free alone,
  /// together, or in part.
  System system(int blocks, int residuals) {
    std::vector<int> dims;
    for (int b = 0; b < blocks; ++b) dims.push_back(1 + below(6));
    System s(dims);
    for (int r = 0; r < residuals; ++r) {
      std::vector<int> touched = {below(blocks)};
      for (int more = below(3); more > 0; --more) {
        const int other = below(blocks);
        if (std::count(touched.begin(), touched.end(), other) == 0) touched.push_back(other);
      }
      const int rows = 1 + below(4);
      const double weight = std::pow(10.0, below(7) - 3);
      std::vector<Eigen::MatrixXd> parts;
      for (int b : touched) parts.push_back(weight * matrix(rows, dims[b]));
      // Some say nothing about one of their variables.
      if (below(10) == 0) parts[below(static_cast<int>(parts.size()))].setZero();
      s.add(touched, parts, below(5) != 0);
    }
    return s;
  }
  /// A random rotation of the frame of each block.
  void rotate(System& s) {
    std::vector<Eigen::MatrixXd> rotations;
    for (int dim : s.layout.dims) {
      rotations.push_back(Eigen::HouseholderQR<Eigen::MatrixXd>(matrix(dim, dim)).householderQ());
    }
    for (const auto& r : s.layout.residuals) {
      double* entry = s.J.data() + r.jacobian;
      for (int i = 0; i < r.count; ++i) {
        const int b = s.layout.blocks[r.first + i];
        Eigen::Map<Eigen::MatrixXd> part(entry, r.rows, s.layout.dims[b]);
        part = (part * rotations[b]).eval();
        entry += part.size();
      }
    }
  }

 private:
  std::mt19937 rng_;
};

/// The null space by a singular value decomposition, columns scaled by block.
Eigen::MatrixXd dense_null_space(const System& s) {
  Eigen::MatrixXd J = s.dense();
  std::vector<double> norms;
  for (std::size_t b = 0; b < s.layout.dims.size(); ++b) {
    auto columns = J.middleCols(s.starts[b], s.layout.dims[b]);
    norms.push_back(columns.norm() > 0.0 ? columns.norm() : 1.0);
    columns /= norms.back();
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(J, Eigen::ComputeFullV);
  int rank = 0;
  while (rank < svd.singularValues().size() && svd.singularValues()[rank] > 1e-12) ++rank;
  return svd.matrixV().rightCols(J.cols() - rank);
}

double projection_gap(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return (a * a.transpose() - b * b.transpose()).norm();
}

TEST(ExtendedCholesky, FindsTheNullSpaceOfRandomSystems) {
  RandomSystems random(1);
  int regular = 0, several = 0, partial = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const int blocks = 1 + random.below(8);
    System s = random.system(blocks, 1 + random.below(4 * blocks));
    if (trial % 2 == 1) random.rotate(s);
    const Eigen::MatrixXd null = dense_null_space(s);
    const ExtendedCholesky factor = s.factor();
    EXPECT_EQ(factor.nullity(), null.cols()) << "trial " << trial;
    for (int b = 0; b < blocks; ++b) {
      if (null.cols() == 0) {
        ASSERT_EQ(factor.free_directions(b).cols(), 0) << "trial " << trial << " block " << b;
        continue;
      }
      const Eigen::JacobiSVD<Eigen::MatrixXd> moves(null.middleRows(s.starts[b], s.layout.dims[b]),
                                                    Eigen::ComputeThinU);
      const auto& sizes = moves.singularValues().array();
      // Next to nothing, as some weights make of a motion, is not told from rounding.
      if (((sizes > 1e-10) && (sizes < 1e-5)).any()) continue;
      const int count = (sizes > 1e-5).count();
      ASSERT_EQ(factor.free_directions(b).cols(), count) << "trial " << trial << " block " << b;
      EXPECT_LT(projection_gap(factor.free_directions(b), moves.matrixU().leftCols(count)), 1e-6);
      EXPECT_EQ(factor.motion(b) > 0.0, count > 0);
      partial += count > 0 && count < s.layout.dims[b];
    }
    regular += null.cols() == 0;
    several += null.cols() > 1;
  }
  EXPECT_GT(regular, 50);
  EXPECT_GT(several, 50);
  EXPECT_GT(partial, 50);
}

// What is estimable has the covariance that any generalised inverse gives it.
TEST(ExtendedCholesky, CovarianceOfWhatIsDetermined) {
  RandomSystems random(2);
  int compared = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const int blocks = 2 + random.below(6);
    const System s = random.system(blocks, 2 * blocks + random.below(blocks));
    const ExtendedCholesky factor = s.factor();
    const Eigen::MatrixXd J = s.dense();
    Eigen::VectorXd scale = J.colwise().norm().cwiseMax(1e-300).cwiseInverse();
    for (int i = 0; i < scale.size(); ++i) scale[i] = scale[i] > 1e200 ? 1.0 : scale[i];
    const Eigen::MatrixXd scaled = J * scale.asDiagonal();
    const Eigen::MatrixXd inverse =
        Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>(scaled).pseudoInverse();
    const Eigen::MatrixXd sigma =
        scale.asDiagonal() * (inverse * inverse.transpose()) * scale.asDiagonal();
    std::vector<int> determined;
    for (int b = 0; b < blocks; ++b) {
      if (factor.free_directions(b).cols() == 0) determined.push_back(b);
    }
    // J'J has the square of the condition of J, of which the weakest direction kept decides.
    double weakest = 1.0;
    const Eigen::VectorXd sizes = Eigen::JacobiSVD<Eigen::MatrixXd>(scaled).singularValues();
    for (double x : sizes) {
      if (x > 1e-12) weakest = std::min(weakest, x);
    }
    const double tolerance = 1e-8 + 1e-18 / (weakest * weakest);
    const Eigen::MatrixXd joint = factor.covariance(determined);
    for (std::size_t i = 0, row = 0; i < determined.size(); ++i) {
      const int a = determined[i], rows = s.layout.dims[a];
      for (std::size_t j = 0, col = 0; j < determined.size(); ++j) {
        const int b = determined[j], cols = s.layout.dims[b];
        const Eigen::MatrixXd expected = sigma.block(s.starts[a], s.starts[b], rows, cols);
        const double size = std::sqrt(sigma.block(s.starts[a], s.starts[a], rows, rows).norm() *
                                      sigma.block(s.starts[b], s.starts[b], cols, cols).norm());
        EXPECT_LT((joint.block(row, col, rows, cols) - expected).norm(), tolerance * size);
        ++compared;
        col += cols;
      }
      row += rows;
    }
  }
  EXPECT_GT(compared, 500);
}

/// Poses in the plane one metre apart with odometry of 0.02 m and 0.01 rad, without or with a prior
/// on the first: the largest relative pivot that is rounding, the smallest that is none.
System chain(int n, double prior) {
  System s(std::vector<int>(n, 3));
  const Eigen::Vector3d weight(1 / 0.02, 1 / 0.02, 1 / 0.01);
  if (prior > 0.0) s.add({0}, {Eigen::Matrix3d(Eigen::Matrix3d::Identity() / prior)});
  for (int i = 1; i < n; ++i) {
    const double turn = 0.3 * std::sin(0.1 * i), c = std::cos(turn), d = std::sin(turn);
    // BetweenSE2: residual in the frame of the first, the second one metre ahead of it.
    Eigen::Matrix3d a, b;
    a << -1, 0, 0, 0, -1, -1, 0, 0, -1;
    b << c, -d, 0, d, c, 0, 0, 0, 1;
    s.add({i - 1, i},
          {Eigen::MatrixXd(weight.asDiagonal() * a), Eigen::MatrixXd(weight.asDiagonal() * b)});
  }
  return s;
}

TEST(ExtendedCholesky, AChainIsDeterminedByItsFirstPoseHoweverLong) {
  for (int n : {2, 100, 10000, 100000}) {
    EXPECT_EQ(chain(n, 0.01).factor().nullity(), 0) << n;
    EXPECT_EQ(chain(n, 100.0).factor().nullity(), 0) << n;
    const ExtendedCholesky free = chain(n, 0.0).factor();
    EXPECT_EQ(free.nullity(), 3) << n;
    for (int b : {0, n / 2, n - 1}) EXPECT_EQ(free.free_directions(b).cols(), 3) << n;
  }
}

TEST(ExtendedCholesky, KnowsHowFarAChainSwings) {
  // Straight ahead: the variance of the lateral position is that of the sum of all turns.
  const int n = 1000;
  System s(std::vector<int>(n, 3));
  s.add({0}, {Eigen::Matrix3d(1e6 * Eigen::Matrix3d::Identity())});
  for (int i = 1; i < n; ++i) {
    Eigen::Matrix3d a;
    a << -1, 0, 0, 0, -1, -1, 0, 0, -1;
    const Eigen::Vector3d weight(1 / 0.02, 1 / 0.02, 1 / 0.01);
    s.add({i - 1, i},
          {Eigen::MatrixXd(weight.asDiagonal() * a), Eigen::MatrixXd(weight.asDiagonal())});
  }
  const Eigen::MatrixXd sigma = s.factor().covariance({n - 1});
  double expected = 0.0;
  for (int k = 1; k < n; ++k) expected += 0.02 * 0.02 + 1e-4 * (k - 1.0) * (k - 1.0);
  EXPECT_NEAR(sigma(1, 1), expected, 1e-3 * expected);
  EXPECT_NEAR(sigma(0, 0), 4e-4 * (n - 1), 1e-6);
}

/// log det of a dense J'J from the QR decomposition of J, all in extended precision.
double dense_log_determinant(const System& s) {
  using Matrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
  const Eigen::HouseholderQR<Matrix> qr(s.dense().cast<long double>());
  return static_cast<double>(2.0L * qr.matrixQR().diagonal().cwiseAbs().array().log().sum());
}

TEST(ExtendedCholesky, LogDeterminantIsThatOfTheDenseMatrix) {
  RandomSystems random(3);
  int regular = 0, singular = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const int blocks = 1 + random.below(6);
    const System s = random.system(blocks, 1 + random.below(5 * blocks));
    const ExtendedCholesky factor = s.factor();
    if (factor.nullity() > 0) {
      EXPECT_EQ(factor.log_determinant(), -std::numeric_limits<double>::infinity());
      ++singular;
      continue;
    }
    const double expected = dense_log_determinant(s);
    EXPECT_NEAR(factor.log_determinant(), expected, 1e-6) << "trial " << trial;
    ++regular;
  }
  EXPECT_GT(regular, 50);
  EXPECT_GT(singular, 50);
}

// A chain held weakly at one end: a factorisation in double precision has lost the prior.
TEST(ExtendedCholesky, LogDeterminantWhereDoublePrecisionFails) {
  for (const double prior : {1e4, 1e5}) {
    const System s = chain(150, prior);
    const Eigen::MatrixXd J = s.dense();
    const double expected = dense_log_determinant(s);
    EXPECT_NEAR(s.factor().log_determinant(), expected, 1e-4) << prior;
    const Eigen::LLT<Eigen::MatrixXd> in_double(J.transpose() * J);
    const double rounded =
        2.0 * Eigen::MatrixXd(in_double.matrixL()).diagonal().array().log().sum();
    EXPECT_FALSE(std::abs(rounded - expected) < 0.01) << prior;
  }
}

/// Blocks that are all tied to each other, and some that no residual moves, though it names them.
TEST(ExtendedCholesky, LeavesOutWhatNothingIsSaidOf) {
  RandomSystems random(9);
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<int> dims;
    int free = 0;
    const int silent = random.below(4), tied = 8 + random.below(12);
    for (int b = 0; b < silent; ++b) {
      dims.push_back(1 + random.below(6));
      free += dims.back();
    }
    for (int b = 0; b < tied; ++b) dims.push_back(1 + random.below(6));
    System s(dims);
    for (int b = silent; b < silent + tied; ++b) {
      s.add({b}, {random.matrix(dims[b], dims[b])});
      for (int c = silent; c < b; ++c) {
        s.add({c, b}, {random.matrix(2, dims[c]), random.matrix(2, dims[b])});
      }
      for (int c = 0; c < silent; ++c) {
        s.add({c, b}, {Eigen::MatrixXd::Zero(2, dims[c]), random.matrix(2, dims[b])});
      }
    }
    const ExtendedCholesky factor = s.factor();
    EXPECT_EQ(factor.nullity(), free) << "trial " << trial;
    for (int b = 0; b < silent; ++b) EXPECT_EQ(factor.free_directions(b).cols(), dims[b]);
    EXPECT_EQ(factor.free_directions(silent).cols(), 0);
    EXPECT_TRUE(factor.covariance({silent}).allFinite());
  }
}

TEST(ExtendedCholesky, OfNothing) {
  System s({});
  EXPECT_EQ(s.factor().nullity(), 0);
  EXPECT_EQ(s.factor().covariance({}).size(), 0);
}

}  // namespace
}  // namespace hybrid
