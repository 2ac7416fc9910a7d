// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libhybrid/core/option.h"
#include "libhybrid/discrete/probabilities.h"

namespace HYBRID_API hybrid {

/// What is known beforehand of the classes of landmarks.
struct ClassOptions {
  std::vector<std::string> names;
  std::vector<double> prior;
  std::vector<double> confusion;
  double floor = 1e-6;

  template <class Table>
  static void describe(Table& table) {
    using O = ClassOptions;
    table.option("names", &O::names, kAnyNumber,
                 "classes of landmarks; empty: as the log names them", "class_names");
    table.option("prior", &O::prior, kProbability,
                 "probability of each class before any sighting; empty: all equal", "class_prior");
    table.option(
        "confusion", &O::confusion, kProbability,
        "of the detector: p(detected class | true class), a row for each true class, in the order "
        "of class_names; empty: the scores of the log are taken as calibrated probabilities");
    table.option(
        "floor", &O::floor, {1e-12, 1.0},
        "share of a detection that is a guess among all classes, so that none is ever ruled out",
        "score_floor");
  }
};

/// Which of the options does not fit the others, by its key in an INI, and why.
struct ClassFault {
  std::string key, why;
};
std::optional<ClassFault> find_fault(const ClassOptions& options);

/// The classes a landmark can have and what a detector says about them: phi(s) of eq. 19.
class ClassModel {
 public:
  ClassModel() = default;

  /// Throws Error where the options do not fit each other. `where` is said in messages.
  explicit ClassModel(ClassOptions options, std::string where = "classes");

  /// Takes the names of the log where the configuration gives none; throws Error if neither
  /// has any, or if a name of the log is not among those known.
  void learn_names(const std::vector<std::string>& names);

  const std::vector<std::string>& names() const { return options_.names; }

  /// p(s) of a landmark not seen yet, one per class.
  std::vector<double> prior() const;

  /// p(scores | s) up to a common factor, one per class, all positive. `probabilities` belong to
  /// `names`, the classes of the detector. With a confusion matrix M(s, z) = p(detected z | true s)
  /// this is sum_z probabilities(z) M(s, z); without, the probabilities themselves, as a calibrated
  /// detector trained on equally frequent classes means them. All equal if there are none.
  std::vector<double> likelihood(const std::vector<double>& probabilities,
                                 const std::vector<std::string>& names) const;

  /// The extent [m] of a thing whose detections have this likelihood of each class (empty: none):
  /// the root of the mean square over classes. `extents` has one number for all of them, or one for
  /// each; throws Error where it has another number.
  double extent_of(const std::vector<double>& extents, const std::vector<double>& phi) const;

 private:
  std::size_t index_of(const std::string& name) const;

  ClassOptions options_;
  std::string where_ = "classes";  // for messages
};

}  // namespace hybrid
