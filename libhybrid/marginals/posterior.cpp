// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/marginals/posterior.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <unordered_set>
#include <utility>

#include "libhybrid/marginals/detail/gibbs.h"
#include "libhybrid/marginals/detail/posterior_model.h"

namespace hybrid {
namespace {

/// The number of joint values of some variables, or limit + 1 if there are more than `limit`.
std::size_t bounded_size(const DiscreteIndex& index, const std::vector<Key>& keys,
                         std::size_t limit) {
  std::size_t size = 1;
  for (Key key : keys) {
    size *= static_cast<std::size_t>(index.at(key).key.cardinality);
    if (size > limit) return limit + 1;
  }
  return size;
}

std::vector<double> slice(const std::vector<double>& all, std::size_t& at, int size) {
  const auto begin = all.begin() + static_cast<std::ptrdiff_t>(at);
  at += static_cast<std::size_t>(size);
  return {begin, begin + size};
}

/// Splits concatenated probabilities by variable.
void take_variables(const std::vector<DiscreteKey>& keys, const std::vector<double>& p,
                    const std::vector<double>* error, std::size_t& at, AssignmentPosterior& out) {
  for (const DiscreteKey& key : keys) {
    std::size_t same = at;
    DiscreteProbabilities& variable = out.variables[key.key];
    variable.p = slice(p, at, key.cardinality);
    if (error != nullptr) variable.standard_error = slice(*error, same, key.cardinality);
  }
}

/// Advances to the next joint value, the last variable fastest; false after the last one.
bool next(const std::vector<DiscreteKey>& keys, std::vector<int>& values) {
  for (std::size_t v = keys.size(); v-- > 0;) {
    if (++values[v] < keys[v].cardinality) return true;
    values[v] = 0;
  }
  return false;
}

Error impossible(const PosteriorModel& model, const char* hint) {
  const auto& keys = model.selectors().empty() ? model.rest() : model.selectors();
  return Error("no joint value of " + to_string(keys.front().key) +
               " and the variables tied to it is possible" + hint);
}

/// The posterior of a model by the sum over all joint values of its selectors.
AssignmentPosterior enumerate_posterior(PosteriorModel& model) {
  AssignmentPosterior out;
  std::vector<int> values(model.selectors().size(), 0);
  double most = -INFINITY;
  do {
    most = std::max(most, model.at(values).log);
  } while (next(model.selectors(), values));
  if (!model.under_constrained().empty()) return out;
  if (!std::isfinite(most)) throw impossible(model, "");
  int size = 0;
  for (const DiscreteKey& key : model.selectors()) size += key.cardinality;
  for (const DiscreteKey& key : model.rest()) size += key.cardinality;
  std::vector<double> p(size, 0.0);
  double total = 0.0;
  do {
    const PosteriorModel::Weight& weight = model.at(values);
    const double w = std::exp(weight.log - most);
    out.joint.push_back(w);
    total += w;
    std::size_t at = 0;
    for (std::size_t v = 0; v < values.size(); ++v) {
      p[at + values[v]] += w;
      at += model.selectors()[v].cardinality;
    }
    for (double q : weight.rest) p[at++] += w * q;
  } while (next(model.selectors(), values));
  for (double& w : out.joint) w /= total;
  for (double& w : p) w /= total;
  std::size_t at = 0;
  take_variables(model.selectors(), p, nullptr, at, out);
  take_variables(model.rest(), p, nullptr, at, out);
  return out;
}

/// The same by block Gibbs sampling, from the values of the estimate.
AssignmentPosterior sample_posterior(PosteriorModel& model, const PosteriorOptions& options) {
  AssignmentPosterior out;
  out.exact = false;
  GibbsModel gibbs;
  for (const DiscreteKey& key : model.selectors()) gibbs.cardinalities.push_back(key.cardinality);
  gibbs.pairs = model.pairs();
  double most = -INFINITY;
  gibbs.log_weight = [&](const std::vector<int>& values) {
    const double log = model.at(values).log;
    most = std::max(most, log);
    return log;
  };
  int size = 0;
  for (const DiscreteKey& key : model.rest()) size += key.cardinality;
  if (size > 0) {
    gibbs.expectations = [&](const std::vector<int>& values) {
      std::vector<double> rest = model.at(values).rest;
      rest.resize(size, 0.0);  // there are none while the values are impossible
      return rest;
    };
  }
  const BatchMeans means = sample_marginals(
      gibbs, model.present(), {options.standard_error, options.max_sweeps, options.seed});
  if (!model.under_constrained().empty()) return out;
  if (!std::isfinite(most)) {
    throw impossible(model, " of those that were sampled; begin with values that are");
  }
  const std::vector<double> p = means.mean();
  const std::vector<double> error = means.standard_error();
  std::size_t at = 0;
  take_variables(model.selectors(), p, &error, at, out);
  take_variables(model.rest(), p, &error, at, out);
  return out;
}

/// The inputs of one call.
struct Context {
  const HybridGraph& graph;
  const Estimate& estimate;
  const JointCovariance& covariance;
  const PosteriorOptions& options;
  DiscreteIndex index;

  bool selects(Key key) const { return index.at(key).selects; }
};

bool few(const Context& context, const std::vector<Key>& selectors) {
  const std::size_t limit = std::max<std::size_t>(context.options.max_assignments, 1);
  return bounded_size(context.index, selectors, limit) <= limit;
}

/// The posterior of some selectors, of `others` (which choose nothing), and of the variables that
/// choose nothing and are connected with these.
AssignmentPosterior solve(const Context& context, const std::vector<Key>& selectors,
                          const std::vector<Key>& others) {
  std::vector<Key> start = selectors;
  start.insert(start.end(), others.begin(), others.end());
  std::vector<Key> rest =
      context.index.connected(start, [&](Key key) { return !context.selects(key); });
  rest.erase(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(selectors.size()));
  const bool enumerated = few(context, selectors);
  using Laplace = PosteriorModel::Laplace;
  PosteriorModel model(context.graph, context.index, context.estimate, selectors, rest,
                       enumerated ? Laplace::kReoptimized : Laplace::kLinearized,
                       context.covariance, context.options.limits);
  AssignmentPosterior out =
      enumerated ? enumerate_posterior(model) : sample_posterior(model, context.options);
  out.under_constrained = model.under_constrained();
  if (out.under_constrained.empty()) return out;
  out.undetermined = selectors;
  out.undetermined.insert(out.undetermined.end(), rest.begin(), rest.end());
  return out;
}

/// Adds the results for the wanted variables; the first result for a variable is kept.
template <class Wanted>
void merge(AssignmentPosterior&& from, const Wanted& wanted, AssignmentPosterior& into) {
  for (auto& [key, variable] : from.variables) {
    if (wanted(key)) into.variables.emplace(key, std::move(variable));
  }
  for (Key key : from.undetermined) {
    if (wanted(key)) into.undetermined.push_back(key);
  }
  into.exact = into.exact && from.exact;
  into.under_constrained.insert(into.under_constrained.end(), from.under_constrained.begin(),
                                from.under_constrained.end());
}

/// Solves overlapping windows along the selectors of a component and keeps the middle half of each.
template <class Wanted>
void solve_in_windows(const Context& context, const std::vector<Key>& selectors,
                      const Wanted& wanted, AssignmentPosterior& out) {
  const int n = static_cast<int>(selectors.size());
  const int window = std::max(context.options.window, 1);
  const int margin = window / 4;
  const int core = window - 2 * margin;
  for (int begin = 0; begin < n; begin += core) {
    const int end = std::min(n, begin + core);
    const auto first = selectors.begin() + std::max(0, begin - margin);
    const auto last = selectors.begin() + std::min(n, end + margin);
    const std::unordered_set<Key> core_keys(selectors.begin() + begin, selectors.begin() + end);
    merge(
        solve(context, {first, last}, {}),
        [&](Key key) {
          return wanted(key) && (core_keys.count(key) != 0 || !context.selects(key));
        },
        out);
  }
}

/// Covariances from a factorisation that the first call makes.
JointCovariance batch_covariance(const HybridGraph& graph, const Estimate& estimate) {
  return [&graph, &estimate, marginals = std::shared_ptr<const ContinuousMarginals>()](
             const std::vector<Key>& keys) mutable {
    if (marginals == nullptr) marginals = std::make_shared<ContinuousMarginals>(graph, estimate);
    return marginals->valid() ? marginals->joint_covariance(keys) : Eigen::MatrixXd();
  };
}

}  // namespace

const DiscreteProbabilities& AssignmentPosterior::at(Key key) const {
  const auto it = variables.find(key);
  if (it == variables.end()) {
    throw Error("discrete variable " + to_string(key) + " has no posterior");
  }
  return it->second;
}

AssignmentPosterior posterior(const HybridGraph& graph, const Estimate& estimate,
                              const std::vector<Key>& keys, const JointCovariance& covariance,
                              const PosteriorOptions& options) {
  const Context context{graph, estimate, covariance, options, DiscreteIndex(graph)};
  std::vector<Key> selectors, others;
  for (Key key : keys) (context.selects(key) ? selectors : others).push_back(key);
  AssignmentPosterior all = solve(context, selectors, others);
  AssignmentPosterior out;
  if (others.empty()) out.joint = std::move(all.joint);
  const std::unordered_set<Key> asked(keys.begin(), keys.end());
  merge(
      std::move(all), [&](Key key) { return asked.count(key) != 0; }, out);
  return out;
}

AssignmentPosterior posterior(const HybridGraph& graph, const Estimate& estimate,
                              const std::vector<Key>& keys, const PosteriorOptions& options) {
  return posterior(graph, estimate, keys, batch_covariance(graph, estimate), options);
}

AssignmentPosterior posterior_marginals(const HybridGraph& graph, const Estimate& estimate,
                                        const std::vector<Key>& keys,
                                        const JointCovariance& covariance,
                                        const PosteriorOptions& options) {
  const Context context{graph, estimate, covariance, options, DiscreteIndex(graph)};
  std::unordered_map<Key, std::size_t> place;
  for (std::size_t i = 0; i < keys.size(); ++i) place.emplace(keys[i], i);
  const auto asked = [&](Key key) { return place.count(key) != 0; };
  AssignmentPosterior out;
  std::unordered_set<Key> done;
  for (Key key : keys) {
    if (done.count(key) != 0) continue;
    const std::vector<Key> component = context.index.connected({key}, [](Key) { return true; });
    done.insert(component.begin(), component.end());
    std::vector<Key> selectors, others;
    for (Key own : component) (context.selects(own) ? selectors : others).push_back(own);
    std::stable_sort(selectors.begin(), selectors.end(), [&](Key a, Key b) {
      const auto of_a = place.find(a), of_b = place.find(b);
      if (of_a == place.end() || of_b == place.end())
        return of_a != place.end() && of_b == place.end();
      return of_a->second < of_b->second;
    });
    if (few(context, selectors)) {
      merge(solve(context, selectors, others), asked, out);
    } else {
      solve_in_windows(context, selectors, asked, out);
    }
  }
  return out;
}

AssignmentPosterior posterior_marginals(const HybridGraph& graph, const Estimate& estimate,
                                        const std::vector<Key>& keys,
                                        const PosteriorOptions& options) {
  return posterior_marginals(graph, estimate, keys, batch_covariance(graph, estimate), options);
}

}  // namespace hybrid
