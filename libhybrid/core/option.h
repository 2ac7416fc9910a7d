// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

// A struct of options tells once what they mean, by `describe(table)`: from that come the keys of
// INI files (mrpt_plugins/bridge/read_options.h) and the fields in Python (python/fields.h).
//   table.option(name, member, [interval,] meaning[, key])  key in INI files, if not the name
//   table.choice(name, member, meaning, names)              of an enumeration
//   table.field(name, member, meaning)                      not in INI files
// A meaning has neither capital nor full stop, and units in brackets.

/// Interval of a number, bounds included unless `open`.
struct Interval {
  double min = -1e15;  ///< beyond 1e15, doubles are more than 0.1 apart
  double max = 1e15;
  bool open = false;
  bool or_zero = false;  ///< 0, with a meaning of its own, is allowed as well

  constexpr bool contains(double value) const {
    if (or_zero && value == 0) return true;
    return open ? value > min && value < max : value >= min && value <= max;
  }
};

// Plausible ranges by unit. A value outside is a mistake: no quantity is measured so finely, or the
// number carries no information. The squares of all values fit into one system of equations.
inline constexpr Interval kAnyNumber{};
inline constexpr Interval kNonNegative{0.0, 1e9};
inline constexpr Interval kPositive{1e-9, 1e9};
inline constexpr Interval kProbability{0.0, 1.0};
inline constexpr Interval kLength{0.0, 1e6};  ///< [m]
inline constexpr Interval kPositiveLength{1e-6, 1e6};
inline constexpr Interval kDuration{0.0, 1e6};  ///< [s]
inline constexpr Interval kPositiveDuration{1e-6, 1e6};
inline constexpr Interval kSigmaMetres{1e-6, 1e3};

/// The interval with 0 allowed as well.
constexpr Interval or_zero(Interval interval) {
  interval.or_zero = true;
  return interval;
}

/// A value of an enumeration and its name: as it is in INI files, in capitals in Python.
template <class Enum>
struct Named {
  const char* name;
  Enum value;
};

}  // namespace hybrid
