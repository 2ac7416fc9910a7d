// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "libhybrid/core/chi_square.h"
#include "mrpt_plugins/health/detail/run_facts.h"
#include "mrpt_plugins/health/noise_entry.h"
#include "mrpt_plugins/health/some_factors.h"

namespace hybrid {
namespace {

/// Sigmas are wrong by a factor of so much: what they are squared is the ratio below.
constexpr double kDoubtfulFactor = 1.5, kBadFactor = 2;
/// Stated too large makes covariances too large, and no map wrong: doubtful from so much on.
constexpr double kDoubtfulExcess = 3;
constexpr double kSure = 0.999;  // probability at which a ratio is not by chance

/// Squared sigmas of some rows, and how many were expected.
struct SquaredSigmas {
  double sum = 0, redundancy = 0;
  void add(double squared, double leverage) {
    sum += squared;
    redundancy += std::max(0.0, 1 - leverage);
  }
  double ratio() const { return sum / redundancy; }
};

struct KindOfFactor {
  const char* factor;  // its name
  int first, last;     // rows
  const char* name;
  const char* knob;
  const char* scale;  // a factor of the noise, or ""
};

constexpr KindOfFactor kKinds[] = {
    {"bearing-range", 0, 0, "ranges of detections", "[sensor] sigma_range", ""},
    {"bearing-range", 1, 2, "bearings of detections", "[sensor] sigma_yaw_deg", ""},
    {"bearing", 0, 1, "bearings without range", "[sensor] sigma_yaw_deg", ""},
    {"range", 0, 0, "ranges to beacons", "[BeaconRanges] sigma", "BeaconRanges.sigma_factor"},
};

SquaredSigmas squared_sigmas(const RunFacts& facts, const KindOfFactor& kind) {
  std::vector<const ContinuousFactor*> named;
  for (const ContinuousFactor* factor : facts.factors) {
    if (factor->name() == kind.factor) named.push_back(factor);
  }
  SquaredSigmas out;
  for_some_factors(
      named, *facts.marginals, facts.run.estimate.values,
      [&](const Eigen::VectorXd& r, const Eigen::MatrixXd& J, const Eigen::MatrixXd& P) {
        const auto last = std::min<Eigen::Index>(kind.last, r.size() - 1);
        for (Eigen::Index row = kind.first; row <= last; ++row) {
          out.add(r[row] * r[row], (J.row(row) * P * J.row(row).transpose()).value());
        }
      });
  return out;
}

std::string sentence_on(const KindOfFactor& kind, double factor) {
  if (factor > kDoubtfulFactor) {
    return fmt::format("The {} scatter {:.2g} times as much as their stated noise allows.",
                       kind.name, factor);
  }
  if (factor < 1 / kDoubtfulExcess) {
    return fmt::format("The {} scatter {:.2g} times less than their stated noise.", kind.name,
                       1 / factor);
  }
  return fmt::format("The {} scatter as their stated noise says.", kind.name);
}

}  // namespace

HealthEntry noise_entry(const std::string& name, double factor, double redundancy) {
  const double sum = factor * factor * redundancy;
  const int degrees = static_cast<int>(std::lround(redundancy));
  HealthEntry entry;
  entry.name = name;
  entry.value = factor;
  entry.least = 1 / kDoubtfulExcess;
  entry.most = kDoubtfulFactor;
  if (sum > chi_square_quantile(kSure, degrees)) {
    entry.verdict = judge(factor, {kDoubtfulFactor, kBadFactor});
  } else if (sum < chi_square_quantile(1 - kSure, degrees)) {
    entry.verdict = judge(1 / factor, {kDoubtfulExcess, std::numeric_limits<double>::infinity()});
  }
  return entry;
}

void check_residuals(const RunFacts& facts, Health& health) {
  if (!facts.marginals) return;
  for (const KindOfFactor& kind : kKinds) {
    const SquaredSigmas s = squared_sigmas(facts, kind);
    if (s.redundancy < kLeastRedundancy) continue;
    HealthEntry entry =
        noise_entry(std::string("noise of ") + kind.name, std::sqrt(s.ratio()), s.redundancy);
    entry.sentence = sentence_on(kind, entry.value);
    entry.scale = kind.scale;
    if (entry.verdict != HealthVerdict::kGood) entry.knob = kind.knob;
    health.push_back(std::move(entry));
  }
}

}  // namespace hybrid
