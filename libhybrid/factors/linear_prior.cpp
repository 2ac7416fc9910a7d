// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/factors/linear_prior.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <memory>
#include <type_traits>
#include <utility>

#include "libhybrid/core/pivoted_cholesky.h"
#include "libhybrid/factors/anchor_frame.h"

namespace hybrid {
namespace {

std::vector<VariableType> types_of(const std::vector<Key>& keys, const Values& points) {
  std::vector<VariableType> types;
  for (Key key : keys) types.push_back(points.type(key));
  return types;
}

}  // namespace

LinearPrior::LinearPrior(const std::vector<Key>& keys, const Values& points, Eigen::MatrixXd R,
                         Eigen::VectorXd r, std::vector<bool> located)
    : ContinuousFactor(keys, types_of(keys, points), static_cast<int>(R.rows())),
      located_(std::move(located)),
      in_frame_(keys.size(), false),
      R_(std::move(R)),
      r_(std::move(r)) {
  if (R_.cols() != cols() || r_.size() != R_.rows())
    throw Error("a linear prior has matrices that do not fit");
  located_.resize(keys.size(), false);
  for (Key key : keys) {
    const double* x = points.data(key);
    origins_.insert(origins_.end(), x, x + points.type(key).size);
  }
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (located_[i] && is_pose(types()[i])) {
      anchor_ = static_cast<int>(i);
      types()[i].kind == VariableKind::kSE3 ? express<SE3>() : express<SE2>();
      return;
    }
    anchor_at_ += types()[i].size;
    anchor_column_ += types()[i].dim;
  }
}

/// Expresses the origins of located variables in the frame of the anchor, and R in their
/// coordinates.
template <class Pose>
void LinearPrior::express() {
  const AnchorFrame<Pose> frame(Pose::load(origins_.data() + anchor_at_));
  double* origin = origins_.data();
  int column = 0;
  const auto take = [&](const auto& x) {
    using T = std::decay_t<decltype(x)>;
    constexpr int kDim = Variable<T>::kDim;
    const auto at = frame.coordinates(frame.express(x), x);
    R_.middleCols<kDim>(column) *= at.by_variable.inverse();
    R_.middleCols<Pose::kDim>(anchor_column_) -= R_.middleCols<kDim>(column) * at.by_anchor;
    Variable<T>::store(frame.express(x), origin);
  };
  for (std::size_t i = 0; i < types().size(); ++i) {
    const VariableType type = types()[i];
    in_frame_[i] = located_[i] && static_cast<int>(i) != anchor_ && AnchorFrame<Pose>::takes(type);
    if (in_frame_[i]) AnchorFrame<Pose>::load(type, origin, take);
    origin += type.size;
    column += type.dim;
  }
}

ContinuousFactorPtr LinearPrior::from_information(const std::vector<Key>& keys,
                                                  const Values& points,
                                                  const Eigen::MatrixXd& information,
                                                  const Eigen::VectorXd& gradient,
                                                  std::vector<bool> located,
                                                  const Eigen::VectorXd& computed_from) {
  // Scaled so that units do not matter, and rounding errors are those of numbers near one.
  Eigen::VectorXd scale = computed_from.size() > 0 ? computed_from : information.diagonal();
  for (double& s : scale) s = s > 0.0 ? 1.0 / std::sqrt(s) : 0.0;
  const double rounding =
      static_cast<double>(scale.size()) * std::numeric_limits<double>::epsilon();
  const PivotedCholesky factor(scale.asDiagonal() * information * scale.asDiagonal(), rounding);
  const Eigen::VectorXd r = factor.triangle().solve(factor.pivots_of(scale.cwiseProduct(gradient)));
  for (double& s : scale) s = s > 0.0 ? 1.0 / s : 0.0;
  Eigen::MatrixXd R(factor.rank(), scale.size());
  R(Eigen::all, factor.order) = factor.lower.transpose();
  return std::make_shared<LinearPrior>(keys, points, R * scale.asDiagonal(), r, std::move(located));
}

/// The coordinates e of x; `J`, if not null, receives the derivative of R e with respect to the
/// tangents.
template <class Pose>
Eigen::VectorXd LinearPrior::coordinates(const double* const* x, double* J) const {
  Eigen::VectorXd e(cols());
  Eigen::Map<Eigen::MatrixXd> jacobian(J, rows(), J == nullptr ? 0 : cols());
  if (J != nullptr) jacobian = R_;
  const AnchorFrame<Pose> frame(anchor_ < 0 ? Pose() : Pose::load(x[anchor_]));
  const double* origin = origins_.data();
  int column = 0;
  std::size_t i = 0;
  const auto take = [&](const auto& expressed) {
    using T = std::decay_t<decltype(expressed)>;
    constexpr int kDim = Variable<T>::kDim;
    const auto at = frame.coordinates(expressed, Variable<T>::load(x[i]));
    e.segment<kDim>(column) = at.e;
    if (J == nullptr) return;
    const auto R = R_.middleCols<kDim>(column);
    jacobian.middleCols<kDim>(column).noalias() = R * at.by_variable;
    jacobian.middleCols<Pose::kDim>(anchor_column_).noalias() += R * at.by_anchor;
  };
  for (; i < types().size(); ++i) {
    const VariableType type = types()[i];
    if (in_frame_[i]) {
      AnchorFrame<Pose>::load(type, origin, take);
    } else {
      local(type, origin, x[i], e.data() + column);
      if (J != nullptr && type.kind != VariableKind::kVector) {
        const auto R = R_.middleCols(column, type.dim);
        jacobian.middleCols(column, type.dim) += R * local_jacobian(type, origin, x[i]) - R;
      }
    }
    origin += type.size;
    column += type.dim;
  }
  return e;
}

Eigen::VectorXd LinearPrior::coordinates(const double* const* x, double* J) const {
  const bool in_space = anchor_ >= 0 && types()[anchor_].kind == VariableKind::kSE3;
  return in_space ? coordinates<SE3>(x, J) : coordinates<SE2>(x, J);
}

double LinearPrior::cost(const double* const* x) const {
  return 0.5 * (R_ * coordinates(x, nullptr) + r_).squaredNorm();
}

double LinearPrior::linearize(const double* const* x, double* r, double* J) const {
  Eigen::Map<Eigen::VectorXd> residual(r, rows());
  residual = r_;
  residual.noalias() += R_ * coordinates(x, J);
  return 0.5 * residual.squaredNorm();
}

}  // namespace hybrid
