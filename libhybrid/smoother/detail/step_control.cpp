// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/detail/step_control.h"

#include <algorithm>
#include <unordered_map>
#include <vector>

namespace hybrid {
namespace {

/// Gauss-Newton steps that a half-step may take beyond the first.
constexpr int kMoreSteps = 3;
constexpr double kLeastShare = 1e-4;  ///< of a step that leads uphill: less is not tried
constexpr int kDampedSteps = 10;
constexpr double kFirstDamping = 1e-2;  ///< of the information that a variable's own factors give
constexpr double kLeastDamping = 1e-6;  ///< below which a step is as good as undamped
constexpr double kMostDamping = 1e8;
/// Steps that lower the objective by less than this share of what was gained so far are enough.
constexpr double kEnough = 1e-2;

/// Of the decrease that the linear model of a step promises, the share that it must bring.
constexpr double kLeastGain = 0.05;

/// The diagonal of the information that the factors of a variable give it if all others are known;
/// a direction that they see least counts as a thousandth of the mean.
std::vector<double> own_information(int slot, const Values& values, const LinearModels& models) {
  const int dim = values.type(slot).dim;
  std::vector<double> diagonal(dim, 0.0);
  for (int t : models.terms().of_variable(slot)) {
    const Term& term = models.terms()[t];
    if (term.tree_factor < 0) continue;
    const double* h = models.tree().system().hessian(term.tree_factor);
    const int order = models.tree().system().factor(term.tree_factor).order;
    int row = 0;
    for (int other : active_slots(term)) {
      for (int i = row; other == slot && i < row + dim; ++i) {
        diagonal[i - row] += packed_column(h, order, i)[i];
      }
      row += values.type(other).dim;
    }
  }
  double mean = 0.0;
  for (double d : diagonal) mean += d / dim;
  for (double& d : diagonal) d = std::max(d, 1e-3 * mean);
  return diagonal;
}

/// Penalties of the steps of variables, as factors of the tree. Those that are not removed go with
/// the roll-back of a half-step that has failed.
class StepPenalties {
 public:
  StepPenalties(const Values& values, LinearModels& models) : values_(values), models_(models) {}

  /// Lets the steps of some variables cost `damping` times what their own factors say, on the scale
  /// of each variable.
  void set(const std::vector<int>& slots, double damping) {
    for (int slot : slots) {
      const auto [at, is_new] = factor_of_.emplace(slot, -1);
      if (is_new) {
        at->second = models_.add_penalty(slot);
        slots_.push_back(slot);
      }
      const std::vector<double> own = own_information(slot, values_, models_);
      const int dim = values_.type(slot).dim;
      double* h = models_.tree().hessian(at->second);
      for (int i = 0; i < dim; ++i) packed_column(h, dim + 1, i)[i] = damping * own[i];
    }
  }
  void remove() {
    for (int slot : slots_) models_.tree().remove_factor(factor_of_.at(slot));
  }

 private:
  const Values& values_;
  LinearModels& models_;
  std::vector<int> slots_;
  std::unordered_map<int, int> factor_of_;  // by slot
};

}  // namespace

void StepControl::run() {
  ++report_.rounds;
  half_.start_moving();
  const double negligible = std::min(half_.leeway().relinearize, half_.leeway().minor);
  double from = before_;  // the cost when the models were last made again
  for (int tries = 0;; ++tries) {
    half_.solve(half_.leeway(), given_);
    const double gained = before_ - half_.cost();
    const double by_models = from - half_.cost() + half_.costs().model_error();
    if (tries == 0) promised_ = by_models;
    if (gained >= 0.0 && !falls_short(gained)) return;
    if (gained < 0.0 && by_models <= negligible) {
      const Places start = half_.moved();
      return half_.go_along(start, way_from(start, half_.values()), 0.0);
    }
    if (gained >= -negligible && !falls_short(gained)) return go_part_of_the_way(half_.moved());
    if (tries == kMoreSteps) return fall_back();
    // All that moved, not just the worst factors.
    half_.renew_moved(report_);
    from = half_.cost();
    if (!half_.eliminate(given_, report_)) {
      report_.status = UpdateReport::Status::kOk;
      return fall_back();
    }
  }
}

bool StepControl::falls_short(double gained) const {
  return gained < kLeastGain * promised_ - half_.leeway().minor;
}

/// Goes a part of the way from `start` to the present estimate, the largest tried that does not
/// raise the objective; at worst none, with everything to be linearised again in the next update.
void StepControl::go_part_of_the_way(const Places& start) {
  const std::vector<double> way = way_from(start, half_.values());
  double share = 1.0;
  do {
    share = share > kLeastShare ? 0.5 * share : 0.0;
    half_.go_along(start, way, share);
  } while (share > 0.0 && !(half_.cost() <= before_));
  if (share == 0.0) half_.leave_off(start.slots);
}

/// What to do when Gauss-Newton has not brought what it promised: a part of its way where it has
/// led uphill; and where much of the promise is left, damped steps from where the half-step began,
/// if they come to a better place.
void StepControl::fall_back() {
  const Places start = half_.moved();
  if (!(half_.cost() <= before_)) go_part_of_the_way(start);
  if (!falls_short(before_ - half_.cost())) return;
  const Places reached = places_of(start.slots, half_.values());
  const double reached_cost = half_.cost();
  damped_steps(start);
  if (report_.status != UpdateReport::Status::kOk || half_.cost() <= reached_cost) return;
  half_.go_to(reached, report_);
  half_.eliminate(given_, report_);
}

/// Lowers the objective from `start` on by damped steps over its variables, and leaves the tree
/// without damping, linearised at the estimate.
void StepControl::damped_steps(const Places& start) {
  const Values& values = half_.values();
  StepPenalties penalties(values, half_.models());
  half_.go_to(start, report_);
  const double first = half_.cost();
  double cost = first;
  double damping = kFirstDamping;
  double growth = 4.0;
  Places best = start;
  for (int k = 0; k < kDampedSteps && damping < kMostDamping; ++k) {
    penalties.set(best.slots, damping);
    if (!half_.eliminate(given_, report_)) return;
    half_.start_moving();
    half_.solve(Leeway{}, given_);
    const Places before = with_others(best, half_.moved(), values);
    const double gained = cost - half_.cost();
    bool enough = false;
    if (gained > 0.0) {
      const double error = std::max(half_.costs().model_error(), 0.0);
      const double quality = 2.0 * gained / (gained + error) - 1.0;
      cost = half_.cost();
      best = places_of(before.slots, values);
      damping *= std::max(0.1, 1.0 - quality * quality * quality);
      growth = 4.0;
      enough = gained <= kEnough * (first - cost) || damping < kLeastDamping;
    } else {
      best = before;
      damping *= growth;
      growth *= 2.0;
    }
    half_.go_to(best, report_);
    if (enough) break;
  }
  penalties.remove();
  half_.eliminate(given_, report_);
}

}  // namespace hybrid
