// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "mrpt_plugins/bridge/ini_file.h"

namespace HYBRID_API hybrid {

/// The classes a landmark can have and what a detector says about them: phi(s) of eq. 19.
class ClassModel {
 public:
  ClassModel() = default;

  /// Reads the keys `class_names`, `class_prior`, `confusion` and `score_floor`; throws Error where
  /// they do not fit each other.
  explicit ClassModel(IniSection& section);

  /// Takes the names of the log where the configuration gives none; throws Error if neither
  /// has any, or if a name of the log is not among those known.
  void learn_names(const std::vector<std::string>& names);

  const std::vector<std::string>& names() const { return names_; }

  /// p(s) of a landmark not seen yet, one per class.
  std::vector<double> prior() const;

  /// p(scores | s) up to a common factor, one per class, all positive. `probabilities` belong to
  /// `names`, the classes of the detector. With a confusion matrix M(s, z) = p(detected z | true s)
  /// this is sum_z probabilities(z) M(s, z); without, the probabilities themselves, as a calibrated
  /// detector trained on equally frequent classes means them. All equal if there are none.
  std::vector<double> likelihood(const std::vector<double>& probabilities,
                                 const std::vector<std::string>& names) const;

 private:
  std::size_t index_of(const std::string& name) const;

  std::vector<std::string> names_;
  std::vector<double> prior_;
  std::vector<double> confusion_;  // row-major, a row per true class; empty if none
  double floor_ = 1e-6;
  std::string where_;  // for messages
};

}  // namespace hybrid
