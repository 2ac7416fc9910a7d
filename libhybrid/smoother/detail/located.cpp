// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/detail/located.h"

#include <Eigen/LU>
#include <type_traits>

#include "libhybrid/factors/anchor_frame.h"

namespace hybrid {
namespace {

/// Residuals that change by less than this share of what each variable alone would change them do
/// not change: far above rounding, and above the error of derivatives by differences.
constexpr double kTolerance = 1e-6;

/// What a rigid motion of some variables does to the residual: the sum, over those variables, of
/// the derivative by a motion of each (rows x dim). They move together where the sum vanishes.
bool move_together(const std::vector<Eigen::MatrixXd>& motions, std::size_t without) {
  Eigen::MatrixXd sum;
  double alone = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const double norm = motions[i].norm();
    if (i == without || !(norm > 0.0)) continue;
    sum = count == 0 ? motions[i] : Eigen::MatrixXd(sum + motions[i]);
    alone += norm;
    ++count;
  }
  return count >= 2 && sum.norm() <= kTolerance * alone;
}

template <class Pose>
std::vector<bool> located(const ContinuousFactor& factor, const double* const* x,
                          const Eigen::MatrixXd& J, const Pose& anchor) {
  const AnchorFrame<Pose> frame(anchor);
  const std::size_t n = factor.types().size();
  std::vector<Eigen::MatrixXd> motions(n);
  int column = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const VariableType type = factor.types()[i];
    if (AnchorFrame<Pose>::takes(type)) {
      AnchorFrame<Pose>::load(type, x[i], [&](const auto& own) {
        // Coordinates in the frame stay where the variable moves with the anchor.
        const auto at = frame.coordinates(frame.express(own), own);
        motions[i] = J.middleCols(column, type.dim) * -(at.by_variable.inverse() * at.by_anchor);
      });
    }
    column += type.dim;
  }
  // All of them, or all but one that is a calibration.
  for (std::size_t k = 0; k <= n; ++k) {
    const std::size_t without = k == 0 ? n : k - 1;
    if (!move_together(motions, without)) continue;
    std::vector<bool> out(n);
    for (std::size_t i = 0; i < n; ++i) out[i] = i != without && motions[i].norm() > 0.0;
    return out;
  }
  return std::vector<bool>(n, false);
}

}  // namespace

std::vector<bool> located_variables(const ContinuousFactor& factor, const double* const* x,
                                    const Eigen::MatrixXd& J) {
  for (std::size_t i = 0; i < factor.types().size(); ++i) {
    if (factor.types()[i].kind == VariableKind::kSE2) return located(factor, x, J, SE2::load(x[i]));
    if (factor.types()[i].kind == VariableKind::kSE3) return located(factor, x, J, SE3::load(x[i]));
  }
  return std::vector<bool>(factor.types().size(), false);
}

}  // namespace hybrid
