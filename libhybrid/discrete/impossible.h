// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>
#include <vector>

#include "libhybrid/core/key.h"

namespace HYBRID_API hybrid {

/// The first ones of some variables, and how many there are.
inline std::string names_of(const std::vector<Key>& variables) {
  std::string text;
  for (std::size_t i = 0; i < variables.size() && i < 12; ++i) {
    text += (i == 0 ? "" : ", ") + to_string(variables[i]);
  }
  if (variables.size() > 12) text += ", ... (" + std::to_string(variables.size()) + " variables)";
  return text;
}

/// What to say where tables of these variables allow no joint value, or where local search has
/// found none; of the latter none are listed, see DiscreteReport.
inline std::string no_joint_value(const std::vector<Key>& variables) {
  if (variables.empty()) {
    return "local search has found no joint value of finite cost; raise the limits of tables";
  }
  return "no joint value of " + names_of(variables) + " is possible: every one has infinite cost";
}

}  // namespace hybrid
