// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/plugins/class_model.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "libhybrid/core/error.h"

namespace hybrid {

ClassModel::ClassModel(IniSection& section) : where_("[" + section.name() + "]") {
  names_ = section.get("class_names", names_, "classes of landmarks; empty: as the log names them");
  prior_ =
      section.get("class_prior", prior_,
                  "probability of each class before any sighting; empty: all equal", kProbability);
  confusion_ = section.get("confusion", confusion_,
                           "p(detected class | true class), a row for each true class, in the "
                           "order of class_names; empty: the scores of the log are taken as "
                           "calibrated probabilities",
                           kProbability);
  floor_ = section.get("score_floor", floor_,
                       "share of a detection that is a guess among all classes, so that none is "
                       "ever ruled out",
                       {1e-12, 1.0});
  const std::size_t n = names_.size();
  if (n == 0 && !(prior_.empty() && confusion_.empty())) {
    section.fail("class_names", "is needed with class_prior or confusion");
  }
  if (!prior_.empty() && prior_.size() != n) {
    section.fail("class_prior", fmt::format("has {} numbers for {} classes", prior_.size(), n));
  }
  if (!prior_.empty() && std::accumulate(prior_.begin(), prior_.end(), 0.0) <= 0.0) {
    section.fail("class_prior", "is all zero");
  }
  if (confusion_.empty()) return;
  if (confusion_.size() != n * n) {
    section.fail("confusion",
                 fmt::format("has {} numbers, {} classes need {}", confusion_.size(), n, n * n));
  }
  for (std::size_t row = 0; row < n; ++row) {
    const auto begin = confusion_.begin() + static_cast<std::ptrdiff_t>(row * n);
    const double sum = std::accumulate(begin, begin + static_cast<std::ptrdiff_t>(n), 0.0);
    if (std::abs(sum - 1.0) > 1e-6) {
      section.fail("confusion",
                   fmt::format("row of class '{}' sums to {}, not to 1", names_[row], sum));
    }
  }
}

void ClassModel::learn_names(const std::vector<std::string>& names) {
  if (names_.empty()) names_ = names;
  if (names_.empty()) {
    throw Error(
        fmt::format("{}: class_names is needed, as the log does not name its classes", where_));
  }
  for (const std::string& name : names) index_of(name);
}

std::size_t ClassModel::index_of(const std::string& name) const {
  const auto it = std::find(names_.begin(), names_.end(), name);
  if (it == names_.end()) {
    throw Error(fmt::format("{}: the log has class '{}', class_names are: {}", where_, name,
                            fmt::join(names_, " ")));
  }
  return static_cast<std::size_t>(it - names_.begin());
}

std::vector<double> ClassModel::prior() const {
  if (!prior_.empty()) return prior_;
  return std::vector<double>(names_.size(), 1.0 / static_cast<double>(names_.size()));
}

std::vector<double> ClassModel::likelihood(const std::vector<double>& probabilities,
                                           const std::vector<std::string>& names) const {
  const std::size_t n = names_.size();
  if (probabilities.empty()) return std::vector<double>(n, 1.0);
  std::vector<double> detected(n, 0.0), out(n, 0.0);
  for (std::size_t z = 0; z < names.size(); ++z) detected[index_of(names[z])] += probabilities[z];
  for (std::size_t s = 0; s < n; ++s) {
    if (confusion_.empty()) out[s] = detected[s];
    for (std::size_t z = 0; z < n && !confusion_.empty(); ++z) {
      out[s] += detected[z] * confusion_[s * n + z];
    }
    out[s] = (1.0 - floor_) * out[s] + floor_ / static_cast<double>(n);
  }
  return out;
}

}  // namespace hybrid
