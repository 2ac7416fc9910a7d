// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/marginals/detail/posterior_sum.h"

#include <algorithm>
#include <cmath>

#include "libhybrid/marginals/detail/gibbs.h"

namespace hybrid {
namespace {

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

}  // namespace

AssignmentPosterior enumerate_posterior(PosteriorModel& model) {
  AssignmentPosterior out;
  std::vector<int> values(model.selectors().size(), 0);
  double most = -INFINITY;
  do {
    most = std::max(most, model.at(values).log);
  } while (next(model.selectors(), values));
  if (!model.under_constrained().empty()) return out;
  if (!std::isfinite(most)) {
    throw Error("no joint value of " + to_string(model.selectors().front().key) +
                " and the variables tied to it is possible");
  }
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

AssignmentPosterior sample_posterior(PosteriorModel& model, const PosteriorOptions& options) {
  AssignmentPosterior out;
  out.exact = false;
  GibbsModel gibbs;
  for (const DiscreteKey& key : model.selectors()) gibbs.cardinalities.push_back(key.cardinality);
  gibbs.pairs = model.pairs();
  gibbs.log_weight = [&](const std::vector<int>& values) { return model.at(values).log; };
  if (!model.rest().empty()) {
    gibbs.expectations = [&](const std::vector<int>& values) { return model.at(values).rest; };
  }
  const BatchMeans means = sample_marginals(
      gibbs, model.present(), {options.standard_error, options.max_sweeps, options.seed});
  if (!model.under_constrained().empty()) return out;
  const std::vector<double> p = means.mean();
  const std::vector<double> error = means.standard_error();
  std::size_t at = 0;
  take_variables(model.selectors(), p, &error, at, out);
  take_variables(model.rest(), p, &error, at, out);
  return out;
}

}  // namespace hybrid
