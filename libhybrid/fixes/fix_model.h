// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/discrete/table.h"
#include "libhybrid/geometry/eigen.h"
#include "libhybrid/hybrid/hybrid_factor.h"

namespace HYBRID_API hybrid {

/// What errors of positions from satellites are like.
///
/// A fix is false, or its error is one that lasts, common to fixes that follow each other, and a
/// small one of its own. What lasts is that of a good receiver, or the larger bias of signals that
/// were reflected. Either goes on, slowly forgotten, or begins anew, as when the satellites in use
/// change. So the error that lasts is a switching system (Fig. 1a of the paper).
struct FixModel {
  bool modes = true;        ///< else each fix has an error of its own, with the two below
  double huber_width = 0;   ///< beyond which its cost grows only linearly [sigmas]; 0: none
  double gate = 0;          ///< farther off it is left out [m]; 0: none is
  double own_sigma = 0.5;   ///< error of a single fix [m]
  double good_sigma = 2;    ///< error that lasts of good fixes [m], along each axis
  double bias_sigma = 15;   ///< of biased ones [m]
  double lasts = 60;        ///< after which a lasting error is forgotten [s]
  double renewed = 120;     ///< good errors begin anew once in so many seconds
  double good_lasts = 300;  ///< of a run of good fixes [s]
  double bias_lasts = 30;   ///< of a run of biased ones [s]
  double false_share = 0.01;
  double false_reach = 1000;  ///< false fixes are anywhere in a square of this side [m]
};

/// How the error of a fix comes from that of the one before.
enum class ErrorMode : int {
  kGood = 0,        ///< a good one goes on
  kNewGood = 1,     ///< begins anew, and is good
  kBiased = 2,      ///< a biased one goes on
  kNewlyBiased = 3  ///< begins anew, and is biased
};
inline constexpr int kErrorModes = 4;
inline bool is_biased(ErrorMode mode) {
  return mode == ErrorMode::kBiased || mode == ErrorMode::kNewlyBiased;
}
inline bool goes_on(ErrorMode mode) {
  return mode == ErrorMode::kGood || mode == ErrorMode::kBiased;
}

/// Variance [m^2] of an error that begins anew.
double new_variance(const FixModel& model, bool biased);

/// Variance [m^2] of what is added in a time [s] to an error that goes on. Biases vary no faster
/// than good errors.
double added_variance(const FixModel& model, double time);

/// What is left of it then: so much that its variance stays that of new ones.
double kept_share(const FixModel& model, double time, bool biased);

/// -log of the probability that a fix is false, times the density of where it is then. Heights are
/// false by a tenth of `false_reach`. `size`: 2 in the plane, 3 in space.
double false_cost(const FixModel& model, int size);

/// -log p(mode | mode before, time between [s]); infinite where one cannot follow the other. For
/// the first error, `before` is nothing, and none goes on.
double mode_cost(const FixModel& model, const ErrorMode* before, ErrorMode mode, double time);

/// The same as a table over the variable before, or of the first alone, and the new one.
Table mode_table(const FixModel& model, const DiscreteKey* before, DiscreteKey mode, double time);

/// How an error comes from the one before: a component for each ErrorMode. Errors are vectors of
/// `size` entries.
HybridFactorPtr error_step(const FixModel& model, const Key* before, Key error, DiscreteKey mode,
                           double time, int size);

}  // namespace hybrid
