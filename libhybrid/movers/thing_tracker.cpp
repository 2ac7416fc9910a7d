// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/movers/thing_tracker.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "libhybrid/association/matching.h"
#include "libhybrid/discrete/class_evidence.h"
#include "libhybrid/discrete/probabilities.h"
#include "libhybrid/movers/motion_filter.h"

namespace hybrid {
namespace {

/// Sightings of a thing that its motion is told by, the newest: older ones say nothing of where it
/// is next, and each costs a step of its filters at every frame.
constexpr std::size_t kNewest = 40;
/// A thing in view that was missed with less probability than this is gone.
constexpr double kLost = 1e-4;
/// Odds at which a thing counts as moving: two sightings of clutter often look like a mover.
constexpr double kDecisiveOdds = 20;
/// Most nats that the costs of sightings with ids differ by: the id decides.
constexpr double kNamed = 1e6;

template <int D>
MotionFilter<D> filter_of(const std::vector<int>& sightings, std::size_t newest, double births,
                          const MotionPrior& prior, const ThingTracker::Locate& locate) {
  const std::size_t first = sightings.size() - std::min(newest, sightings.size());
  MotionFilter<D> filter(locate(sightings[first]), prior);
  for (std::size_t i = first + 1; i < sightings.size(); ++i) {
    filter.take(locate(sightings[i]), births);
  }
  return filter;
}

}  // namespace

bool ThingTracker::is_on() const {
  return std::any_of(prior_.moving.begin(), prior_.moving.end(), [](double p) { return p > 0; });
}

/// The density of things not seen before, in a frame.
double ThingTracker::births() const {
  return born_ / std::max(1.0, frames_) / look_.space;
}

std::vector<double> ThingTracker::class_belief(const Thing& thing) const {
  const std::vector<double>& prior = look_.class_prior;
  return thing.class_evidence.size() == prior.size() ? posterior(prior, thing.class_evidence)
                                                     : prior;
}

/// The probability that a thing of these classes moves.
double ThingTracker::share_moving(const std::vector<double>& belief) const {
  constexpr double kLeast = 1e-9;  // no evidence is refused for good
  const double p =
      prior_.moving.size() == belief.size()
          ? std::inner_product(belief.begin(), belief.end(), prior_.moving.begin(), 0.0)
          : prior_.moving.front();
  return std::clamp(p, kLeast, 1 - kLeast);
}

void ThingTracker::take(const std::vector<ThingSighting>& frame, const Look& look,
                        const Locate& locate) {
  if (before_) before_->push_back(before());
  look_ = look;
  if (look.is_3d) {
    take_in<3>(frame, locate);
  } else {
    take_in<2>(frame, locate);
  }
}

ThingTracker::Before ThingTracker::before() const {
  Before out{things_.size(), thing_of_.size(), changed_.size(), followed_, {}, born_, frames_,
             look_};
  for (const int t : followed_) {
    const Thing& thing = things_[t];
    out.states.emplace_back(
        thing.sightings.size(),
        Thing{{}, thing.id, thing.class_evidence, thing.log_odds, thing.missed, thing.moves});
  }
  return out;
}

void ThingTracker::take_back() {
  for (; before_ && !before_->empty(); before_->pop_back()) {
    Before& before = before_->back();
    things_.resize(before.things);
    thing_of_.resize(before.sightings);
    changed_.resize(before.changed);
    followed_ = std::move(before.followed);
    for (std::size_t i = 0; i < followed_.size(); ++i) {
      auto& [count, state] = before.states[i];
      Thing& thing = things_[followed_[i]];
      thing.sightings.resize(count);
      state.sightings = std::move(thing.sightings);
      thing = std::move(state);
    }
    born_ = before.born;
    frames_ = before.frames;
    look_ = std::move(before.look);
  }
}

/// One matching of all sightings with all things that are followed, each thing with its probability
/// of being missed so often.
template <int D>
void ThingTracker::take_in(const std::vector<ThingSighting>& frame, const Locate& locate) {
  const double density = births(), log_density = std::log(density);
  const double log_missed = std::log1p(-look_.detected), log_detected = std::log(look_.detected);
  std::vector<MotionFilter<D>> filters;
  std::vector<std::vector<double>> beliefs;
  MatchingProblem problem;
  const auto rows = static_cast<Eigen::Index>(frame.size());
  const auto cols = static_cast<Eigen::Index>(followed_.size());
  problem.matched.setConstant(rows, cols, std::numeric_limits<double>::infinity());
  problem.unmatched.resize(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    problem.unmatched[i] = -log_density + class_cost(frame[i].phi, look_.class_prior);
  }
  for (Eigen::Index j = 0; j < cols; ++j) {
    const Thing& thing = things_[followed_[j]];
    filters.push_back(filter_of<D>(thing.sightings, kNewest, density, prior_, locate));
    beliefs.push_back(class_belief(thing));
    const double moving = share_moving(beliefs.back());
    const double unseen = thing.missed * log_missed;
    for (Eigen::Index i = 0; i < rows; ++i) {
      const ThingSighting& s = frame[i];
      if (s.id != thing.id) continue;
      const double log_p = filters.back().log_density(s.seen, moving);
      const double cost =
          class_cost(s.phi, beliefs.back()) - log_p - unseen - log_detected + log_missed;
      problem.matched(i, j) = s.id ? problem.unmatched[i] - kNamed : cost;
    }
  }
  const std::vector<int> column = best_matching(problem).column;
  for (const int t : followed_) ++things_[t].missed;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const int j = column[i];
    if (j >= 0) {
      add(followed_[j], frame[i]);
      filters[j].take(frame[i].seen, density);
      settle(followed_[j], filters[j].evidence());
      continue;
    }
    const int t = static_cast<int>(things_.size());
    things_.emplace_back();
    things_[t].id = frame[i].id;
    add(t, frame[i]);
    settle(t, MotionFilter<D>(frame[i].seen, prior_).evidence());
    if (frames_ > 0) ++born_;
    followed_.push_back(t);
  }
  ++frames_;
  const auto lost = [&](int t) { return things_[t].missed * log_missed < std::log(kLost); };
  followed_.erase(std::remove_if(followed_.begin(), followed_.end(), lost), followed_.end());
}

void ThingTracker::add(int t, const ThingSighting& sighting) {
  Thing& thing = things_[t];
  thing.missed = 0;
  thing.sightings.push_back(sighting.number);
  thing_of_.resize(std::max(thing_of_.size(), static_cast<std::size_t>(sighting.number) + 1), -1);
  thing_of_[sighting.number] = t;
  add_class_likelihood(sighting.phi, 1.0, thing.class_evidence);
}

void ThingTracker::settle(int t, double evidence) {
  Thing& thing = things_[t];
  thing.log_odds = log_odds_of_motion(evidence, share_moving(class_belief(thing)));
  if ((thing.log_odds > std::log(kDecisiveOdds)) == thing.moves) return;
  thing.moves = !thing.moves;
  changed_.push_back(t);
}

void ThingTracker::decide(const Locate& locate) {
  const double density = births();
  for (int t = 0; t < static_cast<int>(things_.size()); ++t) {
    const std::vector<int>& all = things_[t].sightings;
    const double evidence = look_.is_3d
                                ? filter_of<3>(all, all.size(), density, prior_, locate).evidence()
                                : filter_of<2>(all, all.size(), density, prior_, locate).evidence();
    settle(t, evidence);
  }
}

bool ThingTracker::moves(int number) const {
  return mover_of(number).has_value();
}

std::optional<std::int64_t> ThingTracker::mover_of(int number) const {
  if (number < 0 || number >= static_cast<int>(thing_of_.size())) return std::nullopt;
  const int t = thing_of_[number];
  if (t < 0 || !things_[t].moves) return std::nullopt;
  return t;
}

std::vector<int> ThingTracker::take_changed() {
  std::vector<int> sightings;
  for (const int t : changed_) {
    sightings.insert(sightings.end(), things_[t].sightings.begin(), things_[t].sightings.end());
  }
  changed_.clear();
  return sightings;
}

std::vector<Mover> ThingTracker::movers(const std::vector<double>& times,
                                        const Locate& locate) const {
  std::vector<Mover> out;
  for (std::size_t t = 0; t < things_.size(); ++t) {
    const Thing& thing = things_[t];
    if (!thing.moves) continue;
    std::vector<PointSighting> seen;
    for (const int s : thing.sightings) seen.push_back(locate(s));
    std::stable_sort(seen.begin(), seen.end(),
                     [](const auto& a, const auto& b) { return a.time < b.time; });
    Mover mover;
    mover.id = static_cast<std::int64_t>(t);
    mover.probability = 1 / (1 + std::exp(-thing.log_odds));
    if (!thing.class_evidence.empty()) mover.class_probabilities = class_belief(thing);
    mover.sightings = static_cast<int>(thing.sightings.size());
    mover.states = smoothed_states(seen, times, prior_, look_.is_3d);
    out.push_back(std::move(mover));
  }
  return out;
}

}  // namespace hybrid
