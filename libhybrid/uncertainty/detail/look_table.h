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

/// When a place was looked at: soon before it was measured, soon after, or much later or earlier.
enum class LookTime { kBefore, kAfter, kLate };

/// Looks at measured places, by how far the place was and from which side it was seen. Only what
/// stands still is compared: of a place, the looks soon after count if one soon before found it,
/// and the other way round.
class LookTable {
 public:
  /// Of a log that begins at a time; `reach` is the longest range [m].
  LookTable(double begin, double reach) : begin_(begin), reach_(reach) {}

  /// The looks at one place that was measured at a time follow.
  void begin_place(double time);
  /// The looks at one place that stands still and was measured much earlier follow; they are those
  /// of a time.
  void begin_known_place(double time);
  /// A look from a range, turned by an angle against the measurement's direction of view.
  void add(LookTime when, double range, double turn, bool found);

  Agreement conclude();

 private:
  static constexpr int kRanges = 4, kTurns = 4;
  struct Count {
    double looks = 0, found = 0;
  };
  using Counts = std::array<std::array<Count, kRanges * kTurns>, 2>;  // soon, late
  struct Stretch {
    Counts counts{};
    std::size_t places = 0;  // with late looks
  };
  struct Shares {
    double soon = 0, late = 0, looks = 0;
    double ratio() const;
  };

  struct Look {
    LookTime when = LookTime::kLate;
    std::size_t bin = 0;  // by range and turn
    bool found = false;
  };

  Shares compare(const Counts& soon, const Counts& late, const Counts& spread) const;
  double jackknife() const;
  bool stands(LookTime when) const;
  void end_place();

  double begin_, reach_;
  Counts all_{};
  std::map<long, Stretch> stretches_;
  Stretch* stretch_ = nullptr;
  bool is_known_ = false;    // the present place stands still
  std::vector<Look> looks_;  // of the present place
  std::size_t places_ = 0, seen_late_ = 0;
};

/// The options for a log of a length [s].
AgreementOptions options_for(AgreementOptions options, double length);

/// Which of some looks, by time [s] and robot in order of time, are soon before a time, soon after,
/// and late: at most 30, 30 and 140, evenly spread.
class LookChoice {
 public:
  LookChoice(std::vector<std::pair<double, int>> looks, const AgreementOptions& options);

  /// Positions of looks at what a robot measured at a time.
  std::vector<std::pair<LookTime, std::size_t>> around(double time, int robot) const;

 private:
  std::vector<std::pair<double, int>> looks_;
  AgreementOptions options_;
};

/// How far a direction is from another in the plane, or in space [rad].
double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

}  // namespace hybrid
