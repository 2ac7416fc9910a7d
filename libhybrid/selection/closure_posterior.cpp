// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/selection/closure_posterior.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

#include "libhybrid/selection/innovation.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "libhybrid/solvers/null_space.h"

namespace hybrid {
namespace {

/// A smaller redundancy is rounding error: the closure alone determines a direction.
constexpr double kLeastRedundancy = 1e-12;

/// log of the ratio of the densities of an innovation under the inlier and the outlier model. In
/// the axes of its covariance, whitened by the noise of the closure, it has variance 1 + lambda as
/// an inlier and `variance` + lambda as an outlier.
double log_ratio(const Innovation& innovation, bool in, const OutlierLine& outlier) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(innovation.APAt);
  const Eigen::VectorXd b = axes.eigenvectors().transpose() * innovation.b;
  double sum = 0.0;
  for (int i = 0; i < b.size(); ++i) {
    // An accepted closure has the residual r = (1 - h) b, and 1 + lambda = 1 / (1 - h), with its
    // leverage h.
    const double share = axes.eigenvalues()[i];
    const double redundancy = std::max(1.0 - share, kLeastRedundancy);
    const double inlier_variance = in ? 1.0 / redundancy : 1.0 + std::max(share, 0.0);
    const double square = in ? std::pow(b[i] / redundancy, 2) : b[i] * b[i];
    sum -= 0.5 * (std::log(inlier_variance) + square / inlier_variance);
    if (!std::isfinite(outlier.variance)) continue;
    const double outlier_variance = outlier.variance - 1.0 + inlier_variance;
    sum += 0.5 * (std::log(outlier_variance / outlier.variance) + square / outlier_variance);
  }
  return sum + 0.5 * outlier.offset;
}

}  // namespace

void integrate_poses(const RobustProblem& problem, const MixtureOptions& options,
                     RobustResult& result) {
  if (result.poses_integrated) return;
  const std::vector<bool> accepted = accepted_closures(result.decisions);
  MixtureOptions silent;
  silent.null_hypothesis = 0.0;
  const HybridGraph graph = mixture_graph(problem, silent);
  Problem system(graph, result.values, to_assignment(accepted), 0, WeakComponents::kUncoupled,
                 Elimination::kPlain);
  Problem::State state = system.load(result.values);
  levenberg_marquardt(system, state);
  system.linearize(state);
  system.assemble();
  if (!factorize_undamped(system).usable) return;
  InnovationPredictor predictor(system, state);
  WorkerPool pool(0);
  const SelectedInverse inverse(system.system().cholesky(), pool);
  for (std::size_t k = 0; k < accepted.size(); ++k) {
    const ContinuousFactor& closure = *problem.closures[k];
    const Innovation innovation =
        accepted[k] ? predictor.predict_joined(closure, inverse) : predictor.predict(closure);
    const double ratio = log_ratio(innovation, accepted[k], outlier_line(closure, options));
    result.decisions[k].inlier_probability = 1.0 / (1.0 + std::exp(-ratio));
  }
  result.poses_integrated = true;
}

}  // namespace hybrid
