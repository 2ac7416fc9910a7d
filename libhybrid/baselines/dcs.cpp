// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/baselines/dcs.h"

#include <algorithm>

namespace hybrid {

double dcs_scale(double chi_square, double phi) {
  return std::min(1.0, 2.0 * phi / (phi + chi_square));
}

Kernel dcs_kernel(double phi) {
  return {[phi](double s) { return s <= phi ? s : phi * (3.0 * s - phi) / (s + phi); },
          [phi](double s) {
            const double scale = dcs_scale(s, phi);
            return scale * scale;
          }};
}

RobustResult solve_dcs(const RobustProblem& problem, const DcsOptions& options) {
  if (!(options.phi > 0.0)) {
    throw Error("phi of dynamic covariance scaling must be positive, got " +
                std::to_string(options.phi));
  }
  const std::vector<Kernel> kernels(problem.closures.size(), dcs_kernel(options.phi));
  // A scale of one half is a weight of one quarter.
  RobustResult result = solve_kernels(problem, kernels, 0.25, options);
  result.method = "dcs";
  return result;
}

}  // namespace hybrid
