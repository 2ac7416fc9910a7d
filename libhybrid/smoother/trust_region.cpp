// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// What the smoother does when Gauss-Newton steps do not do what their linear model promised:
// Levenberg-Marquardt from where the half-step began, over the variables that it moved.
#include <algorithm>
#include <cmath>
#include <unordered_set>
#include <utility>
#include <vector>

#include "libhybrid/smoother/detail/map_of.h"

namespace hybrid {
namespace {

constexpr double kLeastShare = 1e-4;  ///< of a step that leads uphill: less is not tried
constexpr int kDampedSteps = 10;
constexpr double kFirstDamping = 1e-2;  ///< of the information that a variable's own factors give
constexpr double kLeastDamping = 1e-6;  ///< below which a step is as good as undamped
constexpr double kMostDamping = 1e8;
/// Steps that lower the objective by less than this share of what was gained so far are enough.
constexpr double kEnough = 1e-2;

/// Of the decrease that the linear model of a step promises, the share that it must bring.
constexpr double kLeastGain = 0.05;

}  // namespace

bool IncrementalSmoother::falls_short(double gained, double promised) const {
  return gained < kLeastGain * promised - leeway_.minor;
}

/// A place, and where the variables are there that it does not have.
IncrementalSmoother::Place IncrementalSmoother::with(const Place& place,
                                                     const Place& others) const {
  Place all = place;
  std::unordered_set<int> known(place.slots.begin(), place.slots.end());
  const double* x = others.numbers.data();
  for (int slot : others.slots) {
    const int size = values().type(slot).size;
    if (known.insert(slot).second) {
      all.slots.push_back(slot);
      all.numbers.insert(all.numbers.end(), x, x + size);
    }
    x += size;
  }
  return all;
}

/// The estimates of some variables.
IncrementalSmoother::Place IncrementalSmoother::place_of(std::vector<int> slots) const {
  Place place{std::move(slots), {}};
  for (int slot : place.slots) {
    const double* x = values().data(slot);
    place.numbers.insert(place.numbers.end(), x, x + values().type(slot).size);
  }
  return place;
}

/// Moves the estimate to a place, to be linearised there at the next elimination.
void IncrementalSmoother::go_to(const Place& place, UpdateReport& report) {
  const double* x = place.numbers.data();
  for (int slot : place.slots) {
    const int size = values().type(slot).size;
    std::copy_n(x, size, estimate_.edit(slot));
    x += size;
  }
  refresh_costs(place.slots);
  errors_.clear();
  off_.clear();
  make_models_again(touched_, report);
}

/// Lets the steps of some variables cost `damping` times what their own factors say, on the scale
/// of each variable.
void IncrementalSmoother::damp(const std::vector<int>& slots, double damping) {
  for (int slot : slots) {
    const int dim = values().type(slot).dim;
    if (slot >= static_cast<int>(damping_factor_.size())) damping_factor_.resize(slot + 1, -1);
    int& f = damping_factor_[slot];
    if (f < 0) {
      f = tree_.add_factor({slot});
      own_factor(f, -1);
      damped_.push_back(slot);
    }
    const std::vector<double> own = own_information(slot);
    double* h = tree_.hessian(f);
    for (int i = 0; i < dim; ++i) packed_column(h, dim + 1, i)[i] = damping * own[i];
  }
}

void IncrementalSmoother::undamp() {
  for (int slot : damped_) {
    tree_.remove_factor(damping_factor_[slot]);
    damping_factor_[slot] = -1;
  }
  damped_.clear();
}

/// The diagonal of the information that the factors of a variable give it if all others are known;
/// a direction that they see least counts as a thousandth of the mean.
std::vector<double> IncrementalSmoother::own_information(int slot) const {
  const int dim = values().type(slot).dim;
  std::vector<double> diagonal(dim, 0.0);
  for (int t : terms_.of_variable(slot)) {
    const Term& term = terms_[t];
    if (term.tree_factor < 0) continue;
    const double* h = tree_.hessian_of(term.tree_factor);
    const int order = tree_.hessian_order(term.tree_factor);
    int row = 0;
    for (int other : active_slots(term)) {
      for (int i = row; other == slot && i < row + dim; ++i) {
        diagonal[i - row] += packed_column(h, order, i)[i];
      }
      row += values().type(other).dim;
    }
  }
  double mean = 0.0;
  for (double d : diagonal) mean += d / dim;
  for (double& d : diagonal) d = std::max(d, 1e-3 * mean);
  return diagonal;
}

/// Lowers the objective from `start` on by damped steps over its variables, and leaves the tree
/// without damping, linearised at the estimate.
void IncrementalSmoother::damped_steps(const Place& start, UpdateReport& report) {
  go_to(start, report);
  const double first = term_cost_.value();
  double cost = first;
  double damping = kFirstDamping;
  double growth = 4.0;
  Place best = start;
  for (int k = 0; k < kDampedSteps && damping < kMostDamping; ++k) {
    damp(best.slots, damping);
    if (!eliminate(report)) return;
    old_ = {};
    ++old_stamp_;
    solve(Leeway{});
    const Place before = with(best, old_);
    const double gained = cost - term_cost_.value();
    bool enough = false;
    if (gained > 0.0) {
      const double quality = 2.0 * gained / (gained + std::max(model_error_, 0.0)) - 1.0;
      cost = term_cost_.value();
      best = place_of(before.slots);
      damping *= std::max(0.1, 1.0 - quality * quality * quality);
      growth = 4.0;
      enough = gained <= kEnough * (first - cost) || damping < kLeastDamping;
    } else {
      best = before;
      damping *= growth;
      growth *= 2.0;
    }
    go_to(best, report);
    if (enough) break;
  }
  undamp();
  eliminate(report);
}

/// The way from a place to the present estimate, in the tangents of the place.
std::vector<double> IncrementalSmoother::way_from(const Place& start) const {
  std::vector<double> way;
  const double* x = start.numbers.data();
  for (int slot : start.slots) {
    const VariableType type = values().type(slot);
    way.resize(way.size() + type.dim);
    local(type, x, values().data(slot), way.data() + way.size() - type.dim);
    x += type.size;
  }
  return way;
}

/// Moves the estimate to a share of the way from a place; linear models stay.
void IncrementalSmoother::go_along(const Place& start, const std::vector<double>& way,
                                   double share) {
  const double* x = start.numbers.data();
  const double* whole = way.data();
  std::vector<double> step;
  for (int slot : start.slots) {
    const VariableType type = values().type(slot);
    double* at = estimate_.edit(slot);
    if (share > 0.0) {
      step.assign(whole, whole + type.dim);
      for (double& number : step) number *= share;
      retract(type, x, step.data(), at);
    } else {
      std::copy_n(x, type.size, at);
    }
    whole += type.dim;
    x += type.size;
  }
  const MapOf map(*this);
  for (int slot : start.slots) tree_.set_delta(slot, *map.charts());
  refresh_costs(start.slots);
}

/// Goes a part of the way from `start` to the present estimate, the largest tried that does not
/// raise the objective; at worst none, with everything to be linearised again in the next update.
void IncrementalSmoother::go_part_of_the_way(const Place& start, double before) {
  const std::vector<double> way = way_from(start);
  double share = 1.0;
  do {
    share = share > kLeastShare ? 0.5 * share : 0.0;
    go_along(start, way, share);
  } while (share > 0.0 && !(term_cost_.value() <= before));
  if (share > 0.0) return;
  touch(start.slots);
  off_ = touched_;
}

/// What to do when Gauss-Newton has not brought what it promised: a part of its way where it has
/// led uphill; and where much of the promise is left, damped steps from where the half-step began,
/// if they come to a better place.
void IncrementalSmoother::fall_back(double before, double promised, UpdateReport& report) {
  const Place start = old_;
  if (!(term_cost_.value() <= before)) go_part_of_the_way(start, before);
  if (!falls_short(before - term_cost_.value(), promised)) return;
  const Place reached = place_of(start.slots);
  const double reached_cost = term_cost_.value();
  damped_steps(start, report);
  if (report.status != UpdateReport::Status::kOk || term_cost_.value() <= reached_cost) return;
  go_to(reached, report);
  eliminate(report);
}

}  // namespace hybrid
