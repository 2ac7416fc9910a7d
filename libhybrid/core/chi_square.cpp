// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/core/chi_square.h"

#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <string>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

using Double = boost::math::policies::policy<boost::math::policies::promote_double<false>>;

void check_degrees(int degrees) {
  if (degrees < 1) {
    throw Error("a chi-square distribution needs at least 1 degree of freedom, got " +
                std::to_string(degrees));
  }
}

}  // namespace

double chi_square_probability(double x, int degrees) {
  check_degrees(degrees);
  if (std::isnan(x)) throw Error("the chi-square probability of a value that is not a number");
  if (std::isinf(x)) return x > 0.0 ? 1.0 : 0.0;
  return x <= 0.0 ? 0.0 : boost::math::gamma_p(0.5 * degrees, 0.5 * x, Double());
}

double chi_square_quantile(double probability, int degrees) {
  check_degrees(degrees);
  if (!(probability >= 0.0) || !(probability < 1.0)) {
    throw Error("the probability of a chi-square quantile must be in [0, 1), got " +
                std::to_string(probability));
  }
  return 2.0 * boost::math::gamma_p_inv(0.5 * degrees, probability, Double());
}

}  // namespace hybrid
