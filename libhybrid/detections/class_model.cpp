// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/detections/class_model.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <numeric>
#include <sstream>
#include <utility>

#include "libhybrid/core/error.h"

namespace hybrid {

std::optional<ClassFault> find_fault(const ClassOptions& options) {
  const std::size_t n = options.names.size();
  const auto count = [](std::size_t k) { return std::to_string(k); };
  if (!(options.floor > 0 && options.floor <= 1)) {
    return ClassFault{"score_floor", "is not between 0 and 1"};
  }
  if (n == 0 && !(options.prior.empty() && options.confusion.empty())) {
    return ClassFault{"class_names", "is needed with class_prior or confusion"};
  }
  if (!options.prior.empty() && options.prior.size() != n) {
    return ClassFault{"class_prior", "has " + count(options.prior.size()) + " numbers for " +
                                         count(n) + " classes"};
  }
  const auto& prior = options.prior;
  const auto is_probability = [](double p) { return p >= 0 && p <= 1; };
  if (!std::all_of(prior.begin(), prior.end(), is_probability)) {
    return ClassFault{"class_prior", "holds a number that is no probability"};
  }
  if (!prior.empty() && !(std::accumulate(prior.begin(), prior.end(), 0.0) > 0.0)) {
    return ClassFault{"class_prior", "is all zero"};
  }
  if (options.confusion.empty()) return std::nullopt;
  if (options.confusion.size() != n * n) {
    return ClassFault{"confusion", "has " + count(options.confusion.size()) + " numbers, " +
                                       count(n) + " classes need " + count(n * n)};
  }
  if (!std::all_of(options.confusion.begin(), options.confusion.end(), is_probability)) {
    return ClassFault{"confusion", "holds a number that is no probability"};
  }
  for (std::size_t row = 0; row < n; ++row) {
    const auto begin = options.confusion.begin() + static_cast<std::ptrdiff_t>(row * n);
    const double sum = std::accumulate(begin, begin + static_cast<std::ptrdiff_t>(n), 0.0);
    if (std::abs(sum - 1.0) > 1e-6) {
      std::ostringstream why;
      why << std::setprecision(9) << "row of class '" << options.names[row] << "' sums to " << sum
          << ", not to 1";
      return ClassFault{"confusion", why.str()};
    }
  }
  return std::nullopt;
}

ClassModel::ClassModel(ClassOptions options, std::string where)
    : options_(std::move(options)), where_(std::move(where)) {
  if (const auto fault = find_fault(options_)) {
    throw Error(where_ + ": " + fault->key + " " + fault->why);
  }
}

void ClassModel::learn_names(const std::vector<std::string>& names) {
  if (options_.names.empty()) options_.names = names;
  if (options_.names.empty()) {
    throw Error(where_ + ": class_names is needed, as the log does not name its classes");
  }
  for (const std::string& name : names) index_of(name);
}

std::size_t ClassModel::index_of(const std::string& name) const {
  const auto it = std::find(options_.names.begin(), options_.names.end(), name);
  if (it == options_.names.end()) {
    std::string known;
    for (const std::string& other : options_.names) known += " " + other;
    throw Error(where_ + ": the log has class '" + name + "', class_names are:" + known);
  }
  return static_cast<std::size_t>(it - options_.names.begin());
}

std::vector<double> ClassModel::prior() const {
  if (!options_.prior.empty()) return options_.prior;
  return std::vector<double>(options_.names.size(),
                             1.0 / static_cast<double>(options_.names.size()));
}

std::vector<double> ClassModel::likelihood(const std::vector<double>& probabilities,
                                           const std::vector<std::string>& names) const {
  const std::size_t n = options_.names.size();
  if (probabilities.empty()) return std::vector<double>(n, 1.0);
  std::vector<double> detected(n, 0.0), out(n, 0.0);
  for (std::size_t z = 0; z < names.size(); ++z) detected[index_of(names[z])] += probabilities[z];
  for (std::size_t s = 0; s < n; ++s) {
    if (options_.confusion.empty()) out[s] = detected[s];
    for (std::size_t z = 0; z < n && !options_.confusion.empty(); ++z) {
      out[s] += detected[z] * options_.confusion[s * n + z];
    }
    out[s] = (1.0 - options_.floor) * out[s] + options_.floor / static_cast<double>(n);
  }
  return out;
}

double ClassModel::extent_of(const std::vector<double>& extents,
                             const std::vector<double>& phi) const {
  if (extents.size() == 1) return extents.front();
  std::vector<double> belief = prior();
  if (extents.size() != belief.size()) {
    throw Error("extent has " + std::to_string(extents.size()) + " numbers for " +
                std::to_string(belief.size()) + " classes: it needs one for all, or one for each");
  }
  double weights = 0, squares = 0;
  for (std::size_t s = 0; s < belief.size(); ++s) {
    if (!phi.empty()) belief[s] *= phi[s];
    weights += belief[s];
    squares += belief[s] * extents[s] * extents[s];
  }
  return std::sqrt(squares / weights);
}

}  // namespace hybrid
