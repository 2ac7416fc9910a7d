// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-pgo/noise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "libhybrid/factors/inflated.h"
#include "libhybrid/marginals/continuous.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "mrpt_plugins/health/noise_entry.h"
#include "mrpt_plugins/health/some_factors.h"

namespace hybrid {
namespace {

constexpr int kRounds = 10;
constexpr int kSystems = 5;     // linear ones of a round, a budget: the next one goes on
constexpr double kAlike = 1.1;  // scales that differ by less need no further round

struct Kind {
  const char* name;
  std::vector<ContinuousFactorPtr> factors;
  double scale = 1;  // of the sigmas, as far as is known
  double redundancy = 0;
};

/// The factors in force, by kind; those of refused closures are left out.
std::vector<Kind> kinds_of(const Input& input, const std::vector<Loop>& loops) {
  std::vector<Kind> kinds = {{"odometry", {}}, {"closures", {}}, {"others", {}}};
  const std::size_t edges = input.graph.poses2.size() + input.graph.poses3.size();
  const std::vector<const Loop*> loop_of = loops_of_factors(input, loops);
  for (std::size_t f = 0; f < input.factors.size(); ++f) {
    if (loop_of[f] != nullptr && !loop_of[f]->decision.in_force()) continue;
    const std::size_t kind = f >= edges ? 2 : loop_of[f] != nullptr ? 1 : 0;
    kinds[kind].factors.push_back(input.factors[f]);
  }
  return kinds;
}

/// By how much the residuals of a kind exceed its scale; sets how far others check them.
double excess(Kind& kind, const ContinuousMarginals& marginals, const Values& values) {
  double sum = 0;
  kind.redundancy = 0;
  const double variance = kind.scale * kind.scale;
  for_some_factors(
      kind.factors, marginals, values,
      [&](const Eigen::VectorXd& r, const Eigen::MatrixXd& J, const Eigen::MatrixXd& P) {
        kind.redundancy += std::max(0.0, r.size() - (J * (P / variance)).cwiseProduct(J).sum());
        sum += r.squaredNorm() / variance;
      });
  return kind.redundancy < kLeastRedundancy ? 1.0 : std::sqrt(sum / kind.redundancy);
}

HybridGraph scaled_graph(const std::vector<Kind>& kinds) {
  HybridGraph graph;
  for (const Kind& kind : kinds) {
    for (const ContinuousFactorPtr& factor : kind.factors) {
      if (kind.scale == 1) {
        graph.add(factor);
      } else {
        graph.add(std::make_shared<Inflated>(factor, kind.scale * kind.scale));
      }
    }
  }
  return graph;
}

/// The scale of each kind. Where scales differ, residuals of one kind are in part those of another:
/// the graph is solved again with the scales so far, until they stay.
void find_scales(std::vector<Kind>& kinds, Values values) {
  SolverOptions options;
  options.max_iterations = kSystems;
  for (int round = 0; round < kRounds; ++round) {
    const HybridGraph graph = scaled_graph(kinds);
    if (round > 0) values = levenberg_marquardt(graph, {values, {}}, options).values;
    const ContinuousMarginals marginals(graph, Estimate{values, {}});
    double least = std::numeric_limits<double>::infinity(), most = 0;
    for (Kind& kind : kinds) {
      if (kind.factors.empty()) continue;
      const double change = excess(kind, marginals, values);
      if (kind.redundancy < kLeastRedundancy || change == 0) continue;
      kind.scale *= change;
      least = std::min(least, round == 0 ? kind.scale : change);
      most = std::max(most, round == 0 ? kind.scale : change);
    }
    if (!(most > kAlike * least)) return;
  }
}

HealthEntry entry_on(const NoiseRecord& record) {
  const double factor = *record.measured;
  const double redundancy = std::pow(factor / *record.sigma, 2) / 2;
  HealthEntry entry = noise_entry("noise of " + record.kind, factor, redundancy);
  const std::string of = record.kind == "others" ? "priors and landmarks" : record.kind;
  entry.sentence =
      fmt::format("The residuals of {} are {:.2g} times what their information says.", of, factor);
  if (entry.verdict != HealthVerdict::kGood) {
    entry.knob = "the information of the graph";
  }
  return entry;
}

}  // namespace

std::vector<NoiseRecord> graph_noise(const Input& input, const Solution& solution,
                                     const std::vector<Loop>& loops) {
  std::vector<Kind> kinds = kinds_of(input, loops);
  std::string why;
  if (!input.first_hypotheses.empty()) why = "edges have several hypotheses";
  if (solution.values.size() > kMostWithCovariances) {
    why = fmt::format("the graph has more than {} variables", kMostWithCovariances);
  }
  if (why.empty()) find_scales(kinds, solution.values);
  std::vector<NoiseRecord> records;
  for (const Kind& kind : kinds) {
    if (kind.factors.empty()) continue;
    NoiseRecord record;
    record.sensor = "graph";
    record.kind = kind.name;
    record.stated = record.used = 1;
    record.why = why;
    if (kind.redundancy >= kLeastRedundancy) {
      record.measured = kind.scale;
      record.sigma = kind.scale / std::sqrt(2 * kind.redundancy);
    } else if (why.empty()) {
      record.why = "other measurements check it too little";
    }
    if (record.kind == "closures" && solution.variance_factor) {
      record.used = std::sqrt(*solution.variance_factor);
    }
    records.push_back(std::move(record));
  }
  return records;
}

Health information_health(const PoseGraph& graph) {
  if (!is_information_inverted(graph)) return {};
  HealthEntry entry;
  entry.name = "information of the graph";
  entry.value = 1;
  entry.verdict = HealthVerdict::kBad;
  entry.sentence =
      "Most relative poses are stated to be unknown by more than half a turn and more than their "
      "own length. Is the information a covariance?";
  entry.knob = "the inverse of these matrices";
  return {entry};
}

Health noise_health(const std::vector<NoiseRecord>& noise) {
  Health health;
  for (const NoiseRecord& record : noise) {
    if (record.measured) health.push_back(entry_on(record));
  }
  return health;
}

}  // namespace hybrid
