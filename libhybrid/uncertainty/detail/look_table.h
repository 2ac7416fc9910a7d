// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include "libhybrid/uncertainty/agreement.h"

namespace hybrid {

/// Looks at measured places, by how far the place was and from which side it was seen.
class LookTable {
 public:
  /// Of a log that begins at a time; `reach` is the longest range [m].
  LookTable(double begin, double reach) : begin_(begin), reach_(reach) {}

  /// The looks at one place that was measured at a time follow.
  void begin_place(double time);
  /// A look from a range, turned by an angle against the measurement's direction of view.
  void add(bool late, double range, double turn, bool found);

  Agreement conclude() const;

 private:
  static constexpr int kRanges = 4, kTurns = 4;
  struct Count {
    double looks = 0, found = 0;
  };
  using Counts = std::array<std::array<Count, kRanges * kTurns>, 2>;  // soon, late
  struct Shares {
    double soon = 0, late = 0, looks = 0;
    double ratio() const { return late / soon; }
  };

  static Shares compare(const Counts& soon, const Counts& late, double least_soon);
  double jackknife() const;

  double begin_, reach_;
  Counts all_{};
  std::map<long, Counts> stretches_;
  Counts* stretch_ = nullptr;
  std::size_t places_ = 0, seen_late_ = 0;
  bool has_late_ = false;
};

/// Which of some looks, by time [s] and robot in order of time, are soon after or before a time,
/// and which late: at most 60 and 140, evenly spread.
class LookChoice {
 public:
  LookChoice(std::vector<std::pair<double, int>> looks, const AgreementOptions& options);

  /// Positions of looks at what a robot measured at a time, those that are late second.
  std::pair<std::vector<std::size_t>, std::vector<std::size_t>> around(double time,
                                                                       int robot) const;

 private:
  std::vector<std::pair<double, int>> looks_;
  AgreementOptions options_;
};

/// How far a direction is from another in the plane, or in space [rad].
double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

}  // namespace hybrid
