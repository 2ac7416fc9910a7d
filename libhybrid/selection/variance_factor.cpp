// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/selection/variance_factor.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "libhybrid/core/chi_square.h"

namespace hybrid {
namespace {

/// The quantile of the samples that gives the factor; false closures that were accepted within
/// overstated noise are above it.
constexpr double kQuantile = 0.25;
/// Number of newest samples that are used.
constexpr std::size_t kSamples = 200;
/// Innovations whose log |S| per row differ by less than this are of about the same size.
constexpr double kWindow = 1.5;
/// Number of prior samples, which obey the stated noise.
constexpr int kPrior = 5;
/// Gates are this much wider, since tails are heavier than the quartile shows.
constexpr double kSlack = 4.0;

/// The quantile, computed once per thread and number of rows, since gates are evaluated often.
double cached_quantile(double probability, int rows) {
  thread_local double last_probability = -1.0;
  thread_local int last_rows = 0;
  thread_local double value = 0.0;
  if (probability != last_probability || rows != last_rows) {
    value = chi_square_quantile(probability, rows);
    last_probability = probability;
    last_rows = rows;
  }
  return value;
}

}  // namespace

void VarianceFactor::add(const Prediction& innovation, int rows) {
  samples_.push_back({innovation.log_determinant / rows,
                      innovation.chi_square / chi_square_quantile(kQuantile, rows)});
  if (samples_.size() > kSamples) samples_.pop_front();
}

double VarianceFactor::at(const Prediction& innovation, int rows) const {
  std::vector<double> ratios(kPrior, 1.0);
  for (const Sample& sample : samples_) {
    if (std::abs(sample.size - innovation.log_determinant / rows) < kWindow) {
      ratios.push_back(sample.ratio);
    }
  }
  const auto low =
      ratios.begin() + static_cast<std::ptrdiff_t>(kQuantile * static_cast<double>(ratios.size()));
  std::nth_element(ratios.begin(), low, ratios.end());
  return std::min(limit_, *low);
}

bool VarianceFactor::within(double quantile, const Prediction& innovation, int rows,
                            double checked) const {
  const double widest = cached_quantile(quantile, rows);
  if (!(innovation.chi_square <= std::max(widest, checked))) return false;
  const double alone = widest * std::min(1.0, kSlack * at(innovation, rows));
  if (checked <= 0.0) return innovation.chi_square <= alone;
  const double share = std::max(0.0, 2.0 * innovation.redundancy - 1.0);
  return innovation.chi_square <= std::pow(alone, 1.0 - share) * std::pow(checked, share);
}

}  // namespace hybrid
