// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/certificate.h"

#include <Spectra/SymEigsSolver.h>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <type_traits>
#include <unordered_map>

#include "libhybrid/factors/prior.h"
#include "libhybrid/solvers/levenberg_marquardt.h"

namespace hybrid {
namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Triplets = std::vector<Eigen::Triplet<double>>;

constexpr double kRelativeGap = 1e-6;  // largest of a verified estimate

template <class Pose>
using Rotation =
    Eigen::Matrix<double, Pose::Point::RowsAtCompileTime, Pose::Point::RowsAtCompileTime>;

template <class Pose>
struct Edge {
  Key from, to;
  Pose measured;
  double kappa = 1.0, tau = 1.0;
};

template <class Pose>
using OtherPose = std::conditional_t<std::is_same_v<Pose, SE2>, SE3, SE2>;

template <class Pose>
std::vector<Edge<Pose>> edges_of(const std::vector<ContinuousFactorPtr>& factors) {
  constexpr int d = Pose::Point::RowsAtCompileTime;
  constexpr int kRotation = Pose::kDim - d;
  std::vector<Edge<Pose>> edges;
  for (const ContinuousFactorPtr& factor : factors) {
    const auto motion = relative_pose<Pose>(*factor);
    if (!motion && factor->keys().size() > 1 && !relative_pose<OtherPose<Pose>>(*factor)) {
      throw Error(describe(factor->name(), factor->keys()) +
                  ": only graphs of relative poses can be certified");
    }
    if (!motion) continue;
    const typename Pose::Jacobian covariance = motion->information.inverse();
    edges.push_back(
        {factor->keys()[0], factor->keys()[1], motion->measured,
         0.5 * kRotation / covariance.template bottomRightCorner<kRotation, kRotation>().trace(),
         d / covariance.template topLeftCorner<d, d>().trace()});
  }
  return edges;
}

Eigen::Matrix2d spin(const SE2&, int) {
  return (Eigen::Matrix2d() << 0.0, -1.0, 1.0, 0.0).finished();
}
Eigen::Matrix3d spin(const SE3&, int axis) {
  return hat(Eigen::Vector3d::Unit(axis));
}

/// An edge of the isotropic problem: residual t_j - t_i - R_i t, then R_j - R_i
/// R column by column, times the roots of twice the weights, so that the cost
/// is that of the problem.
template <class Pose>
class ChordalEdge
    : public FactorOf<Rotation<Pose>::RowsAtCompileTime*(Rotation<Pose>::RowsAtCompileTime + 1),
                      Pose, Pose> {
 public:
  static constexpr int d = Rotation<Pose>::RowsAtCompileTime;
  static constexpr int kRows = d * (d + 1);
  static constexpr int kRotation = Pose::kDim - d;
  using Base = FactorOf<kRows, Pose, Pose>;
  using Matrix = Eigen::Matrix<double, kRows, Pose::kDim>;

  explicit ChordalEdge(const Edge<Pose>& edge)
      : Base({edge.from, edge.to}, noise(edge)),
        R_(edge.measured.rotation().matrix()),
        t_(edge.measured.translation()) {}

  std::string name() const override { return "chordal edge"; }

  typename Base::Residual evaluate(const Pose& a, const Pose& b, Matrix* Ja,
                                   Matrix* Jb) const override {
    const Rotation<Pose> Ra = a.rotation().matrix(), Rb = b.rotation().matrix();
    typename Base::Residual e;
    e.template head<d>() = b.translation() - a.translation() - Ra * t_;
    Eigen::Map<Rotation<Pose>>{e.data() + d} = Rb - Ra * R_;
    if (Ja == nullptr) return e;
    Ja->setZero();
    Jb->setZero();
    Ja->template topLeftCorner<d, d>() = -Ra;
    Jb->template topLeftCorner<d, d>() = Rb;
    for (int k = 0; k < kRotation; ++k) {
      const Rotation<Pose> turn = spin(a, k);
      Ja->col(d + k).template head<d>() = -Ra * (turn * t_);
      const Rotation<Pose> by_a = -Ra * turn * R_, by_b = Rb * turn;
      Ja->col(d + k).template tail<d * d>() =
          Eigen::Map<const Eigen::Matrix<double, d * d, 1>>(by_a.data());
      Jb->col(d + k).template tail<d * d>() =
          Eigen::Map<const Eigen::Matrix<double, d * d, 1>>(by_b.data());
    }
    return e;
  }

 private:
  static Noise noise(const Edge<Pose>& edge) {
    Eigen::VectorXd sigmas = Eigen::VectorXd::Constant(kRows, std::sqrt(0.5 / edge.kappa));
    sigmas.head(d).setConstant(std::sqrt(0.5 / edge.tau));
    return Noise::diagonal(sigmas);
  }

  Rotation<Pose> R_;
  typename Pose::Point t_;
};

/// The isotropic problem as a quadratic form: Y stacks the transposed
/// translations (but for the first pose, which is at the origin), then the
/// transposed rotations.
template <class Pose>
class QuadraticForm {
 public:
  static constexpr int d = Rotation<Pose>::RowsAtCompileTime;

  QuadraticForm(const std::vector<Edge<Pose>>& edges, const Values& poses) {
    for (const Edge<Pose>& edge : edges) {
      for (const Key key : {edge.from, edge.to}) {
        if (index_.emplace(key, count_).second) ++count_;
      }
    }
    Y_ = Eigen::MatrixXd::Zero(size(), d);
    typename Pose::Point origin = Pose::Point::Zero();
    for (const auto& [key, i] : index_) {
      if (i == 0) origin = poses.at<Pose>(key).translation();
    }
    for (const auto& [key, i] : index_) {
      const Pose pose = poses.at<Pose>(key);
      if (i > 0) Y_.row(i - 1) = (pose.translation() - origin).transpose();
      Y_.template middleRows<d>(rotation(i)) = pose.rotation().matrix().transpose();
    }
    for (const Edge<Pose>& edge : edges) add(edge);
    M_.resize(size(), size());
    M_.setFromTriplets(triplets_.begin(), triplets_.end());
  }

  int poses() const { return count_; }
  int translations() const { return count_ - 1; }
  int size() const { return count_ - 1 + d * count_; }
  double cost() const { return (Y_.transpose() * (M_ * Y_)).trace(); }

  /// M - Lambda.
  Sparse certificate() const {
    const Eigen::MatrixXd MY = M_ * Y_;
    Triplets multipliers;
    for (int i = 0; i < count_; ++i) {
      const Eigen::MatrixXd L = MY.template middleRows<d>(rotation(i)) *
                                Y_.template middleRows<d>(rotation(i)).transpose();
      for (int r = 0; r < d; ++r) {
        for (int c = 0; c < d; ++c) {
          multipliers.emplace_back(rotation(i) + r, rotation(i) + c, 0.5 * (L(r, c) + L(c, r)));
        }
      }
    }
    Sparse Lambda(size(), size());
    Lambda.setFromTriplets(multipliers.begin(), multipliers.end());
    return M_ - Lambda;
  }

  /// tr(Lambda): the dual value, up to the eigenvalue.
  double dual() const {
    const Eigen::MatrixXd MY = M_ * Y_;
    return (Y_.transpose() * MY).trace() -
           (Y_.topRows(translations()).transpose() * MY.topRows(translations())).trace();
  }

  double scale() const { return M_.diagonal().maxCoeff(); }

 private:
  int rotation(int i) const { return count_ - 1 + d * i; }

  /// Adds weight b b' for a sparse vector b.
  void add(double weight, const std::vector<std::pair<int, double>>& b) {
    for (const auto& [r, x] : b) {
      for (const auto& [c, y] : b) triplets_.emplace_back(r, c, weight * x * y);
    }
  }

  void add(const Edge<Pose>& edge) {
    const int i = index_.at(edge.from), j = index_.at(edge.to);
    const Rotation<Pose> R = edge.measured.rotation().matrix();
    const typename Pose::Point t = edge.measured.translation();
    std::vector<std::pair<int, double>> a;
    if (j > 0) a.emplace_back(j - 1, 1.0);
    if (i > 0) a.emplace_back(i - 1, -1.0);
    for (int k = 0; k < d; ++k) a.emplace_back(rotation(i) + k, -t[k]);
    add(edge.tau, a);
    for (int column = 0; column < d; ++column) {
      std::vector<std::pair<int, double>> b{{rotation(j) + column, 1.0}};
      for (int k = 0; k < d; ++k) b.emplace_back(rotation(i) + k, -R(k, column));
      add(edge.kappa, b);
    }
  }

  std::unordered_map<Key, int> index_;
  int count_ = 0;
  Triplets triplets_;
  Sparse M_;
  Eigen::MatrixXd Y_;
};

/// (S + shift I)^-1 with the first variables of S eliminated.
class ShiftedInverse {
 public:
  using Scalar = double;

  ShiftedInverse(const Sparse& S, int eliminated) : S_(S), eliminated_(eliminated) {}

  /// False if S + shift I is not positive definite.
  bool factorize(double shift) {
    Sparse shifted = S_;
    for (Eigen::Index i = eliminated_; i < S_.rows(); ++i) shifted.coeffRef(i, i) += shift;
    ldlt_.compute(shifted);
    return ldlt_.info() == Eigen::Success && ldlt_.vectorD().minCoeff() > 0.0;
  }

  Eigen::Index rows() const { return S_.rows() - eliminated_; }
  Eigen::Index cols() const { return rows(); }
  void perform_op(const double* x, double* y) const {
    Eigen::VectorXd b = Eigen::VectorXd::Zero(S_.rows());
    b.tail(rows()) = Eigen::Map<const Eigen::VectorXd>(x, rows());
    Eigen::Map<Eigen::VectorXd>(y, rows()) = ldlt_.solve(b).tail(rows());
  }

 private:
  const Sparse& S_;
  int eliminated_;
  Eigen::SimplicialLDLT<Sparse> ldlt_;
};

/// The smallest eigenvalue of S with its first variables eliminated; empty if it is not found.
std::optional<double> smallest_eigenvalue(const Sparse& S, int eliminated, double tolerance) {
  ShiftedInverse inverse(S, eliminated);
  double shift = tolerance;
  for (int tries = 0; !inverse.factorize(shift); ++tries) {
    if (tries > 20) return std::nullopt;
    shift *= 10.0;
  }
  const int basis = static_cast<int>(std::min<Eigen::Index>(inverse.rows(), 30));
  Spectra::SymEigsSolver<ShiftedInverse> solver(inverse, 1, basis);
  solver.init();  // with a fixed seed
  solver.compute(Spectra::SortRule::LargestAlge, 1000, 1e-6);
  if (solver.info() != Spectra::CompInfo::Successful) return std::nullopt;
  return 1.0 / solver.eigenvalues()[0] - shift;
}

/// Whether minimising the factors as stated from the verified poses leads below the cost of the
/// estimate: then the estimate is in the basin of another minimum, or has not converged.
bool is_elsewhere(const HybridGraph& stated, const Values& estimate, const Values& verified) {
  SolverOptions options;
  options.relative_decrease = 1e-9;
  const double here = cost(stated, estimate, {});
  const double there = levenberg_marquardt(stated, {verified, {}}, options).report.final_cost();
  return !(there >= here - kRelativeGap * here);
}

template <class Pose>
Certificate certify_edges(const std::vector<ContinuousFactorPtr>& factors,
                          const std::vector<Edge<Pose>>& edges, const Values& estimate) {
  HybridGraph graph;
  Values start;
  for (const Edge<Pose>& edge : edges) {
    graph.emplace<ChordalEdge<Pose>>(edge);
    for (const Key key : {edge.from, edge.to}) {
      if (!start.contains(key)) start.insert(key, estimate.at<Pose>(key));
    }
  }
  const Key first = edges.front().from;  // its prior fixes the frame and costs nothing
  const ContinuousFactorPtr anchor =
      std::make_shared<Prior<Pose>>(first, start.at<Pose>(first), Noise::unit(Pose::kDim));
  graph.add(anchor);
  HybridGraph stated;
  stated.add(anchor);
  for (const ContinuousFactorPtr& factor : factors) {
    if (factor->keys().size() > 1) stated.add(factor);
  }
  SolverOptions options;
  options.relative_decrease = 1e-12;
  const SolverResult nearest = levenberg_marquardt(graph, {start, {}}, options);
  Certificate certificate;
  if (!std::isfinite(nearest.report.final_cost())) {
    certificate.message = "the isotropic problem has no finite cost";
    return certificate;
  }
  const QuadraticForm<Pose> form(edges, nearest.values);
  certificate.cost = form.cost();
  // The zero eigenvalues are known up to rounding, and the gap allows a tolerance.
  const double unknowns = QuadraticForm<Pose>::d * form.poses();
  const double rounding = 1e-11 * form.scale();
  const double tolerance = std::max(rounding, kRelativeGap * certificate.cost / unknowns);
  const auto smallest = smallest_eigenvalue(form.certificate(), form.translations(), tolerance);
  if (!smallest) {
    certificate.message = "the smallest eigenvalue was not found";
    return certificate;
  }
  certificate.min_eigenvalue = *smallest;
  const double gap = certificate.cost - (form.dual() + unknowns * std::min(0.0, *smallest));
  certificate.verified = gap <= tolerance * unknowns;
  if (certificate.verified && is_elsewhere(stated, start, nearest.values)) {
    certificate.verified = false;
    certificate.message = "poses that cost less were found on the way";
  }
  if (gap > rounding * unknowns) {
    certificate.relative_gap = std::clamp(gap / certificate.cost, 0.0, 1.0);
  }
  return certificate;
}

}  // namespace

Certificate certify(const std::vector<ContinuousFactorPtr>& factors, const Values& estimate) {
  const std::vector<Edge<SE2>> planar = edges_of<SE2>(factors);
  if (!planar.empty()) return certify_edges(factors, planar, estimate);
  const std::vector<Edge<SE3>> spatial = edges_of<SE3>(factors);
  if (!spatial.empty()) return certify_edges(factors, spatial, estimate);
  throw Error("nothing to certify: no factor is a relative pose");
}

}  // namespace hybrid
