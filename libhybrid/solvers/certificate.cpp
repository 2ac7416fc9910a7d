// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/certificate.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_set>
#include <utility>

#include "libhybrid/factors/prior.h"
#include "libhybrid/solvers/detail/isotropic_graph.h"
#include "libhybrid/solvers/detail/lifted_descent.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "libhybrid/solvers/relaxation.h"

namespace hybrid {
namespace {

constexpr double kRelativeGap = 1e-6;  // smaller differences of costs do not matter

/// The verification and improvement of one estimate.
template <class Pose>
class Verification {
 public:
  Verification(const std::vector<ContinuousFactorPtr>& factors,
               std::vector<IsotropicEdge<Pose>> graph, const Values& estimate)
      : graph_(std::move(graph)),
        form_(isotropic_form(graph_)),
        reference_(graph_.front().from),
        estimate_(estimate),
        is_bound_(std::all_of(graph_.begin(), graph_.end(),
                              [](const IsotropicEdge<Pose>& edge) { return edge.is_bound; })) {
    std::unordered_set<Key> poses;
    for (const IsotropicEdge<Pose>& edge : graph_) poses.insert({edge.from, edge.to});
    bool anchored = false;
    for (const ContinuousFactorPtr& factor : factors) {
      if (poses.count(factor->keys().front()) == 0) continue;
      stated_.add(factor);
      if (factor->keys().size() > 1 || anchored) continue;
      anchored = true;
      reference_ = factor->keys().front();
    }
    if (anchored) return;
    // The prior fixes the frame and costs nothing.
    stated_.emplace<Prior<Pose>>(reference_, estimate.at<Pose>(reference_),
                                 Noise::unit(Pose::kDim));
  }

  StaircaseResult run(bool improve) {
    StaircaseResult result;
    result.cost = result.cost_before = cost(stated_, estimate_, {});
    IsotropicMinimum minimum = isotropic_minimum(form_, stacked(graph_, estimate_));
    result.certificate = certificate(minimum);
    if (improve && minimum.dual && !result.certificate.isotropic_verified) {
      result.levels = climb(form_, minimum);
      const double bound = minimum.dual->bound;
      const SolverResult other = stated_minimum(minimum.Y);
      if (is_lower(other.report.final_cost(), result.cost)) {
        result.cost = other.report.final_cost();
        estimate_ = other.values;
        result.certificate = certificate(isotropic_minimum(form_, stacked(graph_, estimate_)));
      }
      Certificate& proof = result.certificate;
      proof.relative_gap = std::clamp(1.0 - bound / proof.cost, 0.0, proof.relative_gap);
    }
    result.values = estimate_;
    return result;
  }

 private:
  /// What the minimum nearest to the estimate proves of it.
  Certificate certificate(const IsotropicMinimum& minimum) const {
    Certificate certificate;
    certificate.cost = hybrid::cost(form_, minimum.Y);
    if (!std::isfinite(certificate.cost)) {
      certificate.message = "the isotropic problem has no finite cost";
      return certificate;
    }
    if (!minimum.dual) {
      certificate.message = "the smallest eigenvalue was not found";
      return certificate;
    }
    certificate.min_eigenvalue = minimum.dual->min_eigenvalue;
    certificate.isotropic_verified = minimum.dual->tight;
    if (minimum.dual->gap > 0.0) {
      certificate.relative_gap = std::clamp(minimum.dual->gap / certificate.cost, 0.0, 1.0);
    }
    const double here = cost(stated_, estimate_, {});
    if (is_bound_) {
      const double bound = std::max(0.0, 0.5 * minimum.dual->bound);
      certificate.stated_gap = here > 0.0 ? std::clamp(1.0 - bound / here, 0.0, 1.0) : 0.0;
    }
    if (!certificate.isotropic_verified) return certificate;
    // Else the estimate is in the basin of another minimum, or has not converged.
    const double there = stated_minimum(minimum.Y).report.final_cost();
    if (std::isfinite(there) && !is_lower(there, here)) {
      certificate.verified = is_bound_;
      if (!is_bound_) {
        certificate.message =
            "the noise is not isotropic, or has robust losses: other poses may cost less";
      }
      return certificate;
    }
    certificate.isotropic_verified = false;
    certificate.message = "poses that cost less were found on the way";
    return certificate;
  }

  /// Whether a cost is lower than another by more than solvers leave: a share of it, or steps of
  /// every unknown within their tolerance.
  bool is_lower(double cost, double other) const {
    const double step = SolverOptions().step;
    return cost < other * (1.0 - kRelativeGap) - form_.unknowns() * step * step;
  }

  /// The factors as stated, solved from the poses of the isotropic problem.
  SolverResult stated_minimum(const Eigen::MatrixXd& Y) const {
    SolverOptions options;
    options.relative_decrease = 1e-9;
    const Values start = unstacked(graph_, rounded(form_, Y), reference_, estimate_);
    return levenberg_marquardt(stated_, {start, {}}, options);
  }

  std::vector<IsotropicEdge<Pose>> graph_;
  IsotropicForm form_;
  HybridGraph stated_;
  Key reference_;  // stays where it is
  Values estimate_;
  bool is_bound_ = false;  // the stated factors cost at least as much as the isotropic problem
};

StaircaseResult verify(const std::vector<ContinuousFactorPtr>& factors, const Values& estimate,
                       bool improve) {
  auto planar = relative_poses<SE2>(factors);
  if (!planar.empty()) {
    return Verification<SE2>(factors, std::move(planar), estimate).run(improve);
  }
  auto spatial = relative_poses<SE3>(factors);
  if (!spatial.empty()) {
    return Verification<SE3>(factors, std::move(spatial), estimate).run(improve);
  }
  throw Error("nothing to certify: no factor is a relative pose");
}

}  // namespace

Certificate certify(const std::vector<ContinuousFactorPtr>& factors, const Values& estimate) {
  return verify(factors, estimate, false).certificate;
}

StaircaseResult climb_staircase(const std::vector<ContinuousFactorPtr>& factors,
                                const Values& estimate) {
  return verify(factors, estimate, true);
}

}  // namespace hybrid
