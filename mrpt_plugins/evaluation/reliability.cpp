// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/evaluation/reliability.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace hybrid {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

void check(const ClassPrediction& p, std::size_t index) {
  const auto classes = static_cast<int>(p.probabilities.size());
  if (p.true_class < 0 || p.true_class >= classes) {
    throw std::invalid_argument(
        fmt::format("prediction {}: true class {} of {} classes", index, p.true_class, classes));
  }
  for (const double q : p.probabilities) {
    if (!(q >= 0 && q <= 1 + 1e-9)) {
      throw std::invalid_argument(fmt::format("prediction {}: probability {}", index, q));
    }
  }
}

}  // namespace

Calibration calibration(const std::vector<ClassPrediction>& predictions, int bins) {
  if (bins < 1) throw std::invalid_argument("a reliability diagram needs at least one bin");
  Calibration out;
  out.predictions = predictions.size();
  for (int b = 0; b < bins; ++b) {
    ReliabilityBin bin;
    bin.lower = static_cast<double>(b) / bins;
    bin.upper = static_cast<double>(b + 1) / bins;
    out.bins.push_back(bin);
  }
  for (std::size_t i = 0; i < predictions.size(); ++i) {
    const ClassPrediction& p = predictions[i];
    check(p, i);
    for (std::size_t c = 0; c < p.probabilities.size(); ++c) {
      const double q = p.probabilities[c];
      const double came_true = static_cast<int>(c) == p.true_class ? 1.0 : 0.0;
      out.brier += (q - came_true) * (q - came_true);
      ReliabilityBin& bin = out.bins[std::min(bins - 1, static_cast<int>(q * bins))];
      ++bin.count;
      bin.mean_predicted += q;
      bin.observed += came_true;
    }
    out.log_loss -= std::log(std::max(1e-15, p.probabilities[p.true_class]));
  }
  double total = 0;
  for (ReliabilityBin& bin : out.bins) {
    const double n = bin.count == 0 ? kUnknown : static_cast<double>(bin.count);
    if (bin.count > 0) out.expected_error += std::abs(bin.observed - bin.mean_predicted);
    total += static_cast<double>(bin.count);
    bin.mean_predicted /= n;
    bin.observed /= n;
  }
  const double n = predictions.empty() ? kUnknown : static_cast<double>(predictions.size());
  out.brier /= n;
  out.log_loss /= n;
  out.expected_error /= total > 0 ? total : kUnknown;
  return out;
}

}  // namespace hybrid
