// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/fixes/fix_mapper.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/core/infinity.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/core/quantile.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/factors/position.h"
#include "libhybrid/fixes/biased_position.h"
#include "libhybrid/fixes/datum_alignment.h"
#include "libhybrid/fixes/map_shift.h"
#include "libhybrid/geometry/isometry.h"
#include "libhybrid/hybrid/mixture.h"

namespace hybrid {
namespace {

constexpr double kMostTurn = 0.1;          // rad, sigma of the direction at which the datum enters
constexpr double kShares = 1;              // s in which fixes share the variable of their error
constexpr double kLeastTime = 1e-3;        // s, between two fixes
constexpr double kFollows = 3;             // s in which fixes tell what their own error is
constexpr std::size_t kDifferences = 512;  // of which the median counts
constexpr std::size_t kFew = 10;           // differences, which tell nothing yet
constexpr std::size_t kMostWaiting = 2000;

/// -log of a Gaussian density.
double gaussian_cost(const Eigen::VectorXd& v, const Eigen::MatrixXd& S) {
  const Eigen::LLT<Eigen::MatrixXd> llt(S);
  if (llt.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  const Eigen::VectorXd white = llt.matrixL().solve(v);
  const double log_det = 2 * llt.matrixLLT().diagonal().array().log().sum();
  const auto n = static_cast<double>(v.size());
  return 0.5 * (white.squaredNorm() + log_det + n * std::log(2 * M_PI));
}

/// The Jacobian of where a fix is expected, with regard to the pose.
Eigen::MatrixXd jacobian_of(const Eigen::Isometry3d& T, const Eigen::Vector3d& lever, bool is_3d) {
  if (is_3d) {
    Eigen::Matrix<double, 3, 6> J;
    carried_point(to_se3(T), lever, &J);
    return J;
  }
  Eigen::Matrix<double, 2, 3> J;
  carried_point(to_se2(T), lever.head<2>(), &J);
  return J;
}

template <class Pose>
ContinuousFactorPtr factor_of(const FixEntry& entry, const Eigen::Vector3d& measured,
                              const std::optional<Key>& error, double sigma, Loss loss) {
  constexpr int kRows = Pose::Point::RowsAtCompileTime;
  const typename Pose::Point z = measured.head<kRows>();
  const typename Pose::Point lever = entry.fix.lever_arm().template head<kRows>();
  const Noise noise = Noise::isotropic(kRows, sigma);
  if (error) {
    return std::make_shared<BiasedPosition<Pose>>(entry.pose, *error, z, noise, lever, loss);
  }
  return std::make_shared<Position<Pose>>(entry.pose, z, noise, lever, loss);
}

}  // namespace

/// Where a fix is, by the estimate before it is used.
struct FixMapper::Place {
  int size = 2;
  Eigen::Vector3d antenna;               // where it is expected
  Eigen::VectorXd residual;              // the fix less that
  Eigen::MatrixXd spread;                // covariance of where it is expected
  std::optional<Eigen::VectorXd> error;  // estimate of the lasting error of the fix before
  Eigen::MatrixXd joint_spread;          // of where it is expected with that error
};

ContinuousFactorPtr FixMapper::position_factor(const FixEntry& entry,
                                               const std::optional<Key>& error, double sigma,
                                               bool is_3d, Loss loss) const {
  const Eigen::Vector3d measured = T_datum_map_->inverse() * entry.fix.position;
  return is_3d ? factor_of<SE3>(entry, measured, error, sigma, loss)
               : factor_of<SE2>(entry, measured, error, sigma, loss);
}

double FixMapper::own_sigma(const ReceiverId& id) const {
  constexpr double kLeast = 1e-3;                 // m
  constexpr double kOfMedian = 1.4826 / M_SQRT2;  // sigma of each of two normal numbers
  const auto found = receivers_.find(id);
  if (found == receivers_.end() || found->second.differences.size() < kFew) {
    return model_.own_sigma;
  }
  return std::max(kLeast, kOfMedian * median(found->second.differences));
}

double FixMapper::own_sigma() const {
  std::vector<double> sigmas;
  for (const auto& [id, receiver] : receivers_) sigmas.push_back(own_sigma(id));
  return sigmas.empty() ? model_.own_sigma : median(std::move(sigmas));
}

FixModel FixMapper::model_of(const FixEntry& entry) const {
  const Fix& fix = entry.fix;
  FixModel model = fix.receiver ? *fix.receiver : model_;
  model.modes = model_.modes;
  model.huber_width = model_.huber_width;
  model.gate = model_.gate;
  if (fix.sigma > 0) model.good_sigma = fix.sigma;
  if (!fix.receiver) model.own_sigma = own_sigma(entry.receiver());
  // A single error is no larger than the whole.
  const auto found = receivers_.find(entry.receiver());
  const bool is_measured = found != receivers_.end() && found->second.differences.size() >= kFew;
  if (fix.sigma > 0 && !is_measured) model.own_sigma = std::min(model.own_sigma, fix.sigma);
  return model;
}

Contribution FixMapper::observe(const KeyframeView& frame, const std::vector<Fix>& fixes,
                                const MapView& map, std::size_t robot) {
  for (const Fix& fix : fixes) fixes_.push_back({fix, robot, frame.pose, {}, {}, {}, false, {}});
  return contribute(&frame, map);
}

/// Adds all fixes that wait, once there is a datum.
Contribution FixMapper::contribute(const KeyframeView* frame, const MapView& map) {
  Contribution out;
  for (auto& [robot, error] : state_.newest) error.is_new = false;
  before_ = state_;
  if (!T_datum_map_) return out;
  for (; state_.answered < fixes_.size(); ++state_.answered) {
    add(fixes_[state_.answered], frame, map, out);
  }
  return out;
}

/// Fixes of a log without odometry, with the path that they make.
Contribution FixMapper::contribute_path(const MapView& map) {
  const Values path = poses_at_fixes(fixes_, *T_datum_map_, map.is_3d);
  Values values = map.values;
  for (const Key key : path.keys()) {
    std::copy_n(path.data(key), path.type(key).size, values.data(values.slot(key)));
  }
  const MapView placed{values,        map.assignment, map.landmarks, map.is_3d,
                       map.keeps_all, map.explain,    map.holds};
  Contribution out = contribute(nullptr, placed);
  stands_ = false;
  out.moved = path;
  out.allowed_rise = kInfinity;
  return out;
}

Contribution FixMapper::revise(const MapView& map, bool is_last) {
  if (stands_) return contribute_path(map);
  Contribution out = contribute(nullptr, map);
  const std::size_t all = fixes_.size();
  if (!out.empty() || !T_datum_map_ || !model_.modes || !has_estimates_) return out;
  if (all < (is_last ? shifted_ + 1 : 2 * shifted_)) return out;
  shifted_ = all;
  std::optional<Values> moved = shift_by_bias(fixes_, map);
  if (!moved) return out;
  out.moved = *std::move(moved);
  out.allowed_rise = 0.0;
  return out;
}

void FixMapper::refused() {
  for (std::size_t i = before_.answered; i < state_.answered; ++i) {
    fixes_[i].error.reset();
    fixes_[i].falsity.reset();
    fixes_[i].is_plain = false;
    fixes_[i].unused = "its keyframe was refused";
  }
  before_.answered = state_.answered;
  state_ = before_;
}

void FixMapper::forget_waiting() {
  for (; state_.answered < fixes_.size(); ++state_.answered) {
    fixes_[state_.answered].unused = "most others are farther than 1,000 km";
  }
  before_ = state_;
  looked_ = state_.answered;
}

/// The datum of a log without odometry.
bool FixMapper::take_axes_of_datum() {
  const auto used = std::find_if(fixes_.begin(), fixes_.end(),
                                 [](const FixEntry& entry) { return entry.unused.empty(); });
  if (used == fixes_.end()) return false;
  const Eigen::Vector3d height(0, 0, used->fix.antenna.z());
  T_datum_map_ = Eigen::Isometry3d(Eigen::Translation3d(used->fix.position - height));
  stands_ = true;
  return true;
}

bool FixMapper::find_datum(const MapView& map, bool stands) {
  const std::size_t all = fixes_.size();
  if (stands && !T_datum_map_) return take_axes_of_datum();
  // Looking costs as much as there are fixes: so it is done when a tenth has been added.
  if (T_datum_map_ || all < 3 || 10 * all < 11 * looked_) return false;
  looked_ = all;
  const std::size_t first = all > kMostWaiting ? all - kMostWaiting : 0;
  std::vector<DatumPair> pairs;
  for (std::size_t i = first; i < all; ++i) {
    const FixEntry& entry = fixes_[i];
    if (!entry.unused.empty() || !map.values.contains(entry.pose)) continue;
    pairs.push_back({isometry_at(map.values, entry.pose) * entry.fix.lever_arm(),
                     entry.fix.position, model_of(entry).good_sigma});
  }
  T_datum_map_ = align_to_datum(pairs, kMostTurn);
  return T_datum_map_.has_value();
}

FixMapper::Place FixMapper::place_of(const FixEntry& entry, const KeyframeView* frame,
                                     const MapView& map) {
  Place place;
  place.size = map.is_3d ? 3 : 2;
  const bool is_newest = frame != nullptr && entry.pose == frame->pose;
  const Eigen::Isometry3d T = is_newest ? frame->T_map_robot : isometry_at(map.values, entry.pose);
  const Eigen::Vector3d lever = entry.fix.lever_arm();
  place.antenna = T * lever;
  place.residual = (T_datum_map_->inverse() * entry.fix.position - place.antenna).head(place.size);
  place.spread = Eigen::MatrixXd::Zero(place.size, place.size);
  place.joint_spread = place.spread;
  const auto newest = state_.newest.find(entry.receiver());
  const bool has_error =
      newest != state_.newest.end() && (newest->second.is_new || map.holds(newest->second.key));
  if (has_error) {
    const Error& error = newest->second;
    place.error = error.value;
    if (!error.is_new) *place.error = point_at(map.values, error.key).head(place.size);
  }
  if (is_newest && has_estimates_ && frame->covariance_of) try {
      const Eigen::MatrixXd J = jacobian_of(T, lever, map.is_3d);
      place.spread = frame->covariance_of({}, J);
      if (!has_error || newest->second.is_new) return place;
      Eigen::MatrixXd with_error(J.rows(), J.cols() + place.size);
      with_error << J, Eigen::MatrixXd::Identity(place.size, place.size);
      place.joint_spread = frame->covariance_of({newest->second.key}, with_error);
      return place;
    } catch (const SettingsError&) {
      has_estimates_ = false;  // a batch back-end, which solves at the end
    }
  foresee_by_way(entry, place);
  return place;
}

/// Where no estimate tells how well a fix is foreseen: odometry drifts by a share of the way.
void FixMapper::foresee_by_way(const FixEntry& entry, Place& place) const {
  constexpr double kDrift = 0.03;
  const auto found = receivers_.find(entry.receiver());
  if (found == receivers_.end() || !found->second.last) return;
  const Receiver::Last& last = *found->second.last;
  const double since = (place.antenna - last.antenna).norm();
  const Eigen::MatrixXd I = Eigen::MatrixXd::Identity(place.size, place.size);
  place.spread = std::pow(kDrift * (last.way + since), 2) * I;
  place.joint_spread = std::pow(kDrift * since, 2) * I;
  if (place.error && !has_estimates_) place.error = last.residual;
}

/// Notes by how much a fix differs from the one before beside what odometry tells.
void FixMapper::measure_own(const Place& place, const FixEntry& entry) {
  auto& [last, differences] = receivers_[entry.receiver()];
  if (last && entry.fix.time - last->time <= kFollows) {
    const Eigen::VectorXd difference = place.residual - last->residual;
    if (differences.size() >= kDifferences) {
      differences.erase(differences.begin(), differences.begin() + 2);
    }
    differences.push_back(std::abs(difference.x()));
    differences.push_back(std::abs(difference.y()));
  }
  const double way = last ? last->way + (place.antenna - last->antenna).norm() : 0.0;
  last = Receiver::Last{entry.fix.time, place.residual, place.antenna, way};
}

/// What a fix is, by the density that the map predicts for it: its error goes on or begins anew, or
/// it is false.
FixMapper::Decision FixMapper::decide(const FixEntry& entry, const Place& place,
                                      const MapView& map) const {
  const FixModel model = model_of(entry);
  const int n = place.size;
  const Eigen::MatrixXd I = Eigen::MatrixXd::Identity(n, n);
  const double own = model.own_sigma * model.own_sigma;
  const Error* const last = place.error ? &state_.newest.at(entry.receiver()) : nullptr;
  ErrorMode before = ErrorMode::kNewGood;
  Decision out;
  double since_last = 0;
  if (last != nullptr) {
    const int value = last->is_new ? -1 : map.assignment.find(last->mode.key);
    before = value < 0 ? last->chosen : static_cast<ErrorMode>(value);
    out.since_begin = std::max(0.0, entry.fix.time - last->time);
    since_last = std::max(kLeastTime, entry.fix.time - last->last_time);
  }
  double best = false_cost(model, n);
  for (int i = 0; i < kErrorModes; ++i) {
    const auto mode = static_cast<ErrorMode>(i);
    double cost = -std::log(1 - model.false_share) +
                  mode_cost(model, last != nullptr ? &before : nullptr, mode, since_last);
    if (!std::isfinite(cost)) continue;
    if (goes_on(mode)) {
      const double kept = kept_share(model, out.since_begin, is_biased(mode));
      const Eigen::VectorXd v = place.residual - kept * *place.error;
      const double added = own + added_variance(model, out.since_begin);
      cost += gaussian_cost(v, place.joint_spread + added * I);
    } else {
      const double added = own + new_variance(model, is_biased(mode));
      cost += gaussian_cost(place.residual, place.spread + added * I);
    }
    if (cost >= best) continue;
    best = cost;
    out.mode = mode;
    out.is_false = false;
  }
  return out;
}

/// Adds the factors of a fix.
void FixMapper::add(FixEntry& entry, const KeyframeView* frame, const MapView& map,
                    Contribution& out) {
  const bool is_newest = frame != nullptr && entry.pose == frame->pose;
  if (!is_newest && !map.holds(entry.pose)) {
    entry.unused = "its keyframe had left the window when the datum was found";
    return;
  }
  const Place place = place_of(entry, frame, map);
  const FixModel model = model_of(entry);
  if (!model.modes) {
    add_plain(entry, place, map.is_3d, out);
    return;
  }
  const Decision decision = decide(entry, place, map);
  if (!decision.is_false && !stands_) measure_own(place, entry);
  const bool begins =
      !decision.is_false && (!goes_on(decision.mode) || decision.since_begin >= kShares);
  if (!place.error || begins) begin_error(entry, decision, place, out);
  Error& error = state_.newest.at(entry.receiver());
  if (!decision.is_false) error.last_time = entry.fix.time;
  entry.error = error.key;
  entry.mode = error.mode;
  entry.falsity = Key(key_letter::kFalseFix, falsities_++);
  const double shared = added_variance(model, std::max(0.0, entry.fix.time - error.time));
  const double sigma = std::sqrt(model.own_sigma * model.own_sigma + shared);
  std::vector<MixtureComponent> components{
      {position_factor(entry, error.key, sigma, map.is_3d), -std::log(1 - model.false_share)},
      {nullptr, false_cost(model, place.size)}};
  out.delta.hybrid.push_back(std::make_shared<Mixture>(
      std::vector<DiscreteKey>{{*entry.falsity, 2}}, std::move(components)));
  out.delta.assignment.set(*entry.falsity, decision.is_false ? 1 : 0);
}

/// A fix without modes.
void FixMapper::add_plain(FixEntry& entry, const Place& place, bool is_3d, Contribution& out) {
  const FixModel model = model_of(entry);
  if (model.gate > 0 && place.residual.norm() > model.gate) {
    entry.unused = "farther off than [Fixes] gate";
    return;
  }
  entry.is_plain = true;
  const Loss loss = model.huber_width > 0 ? Loss::huber(model.huber_width) : Loss();
  out.delta.continuous.push_back(position_factor(
      entry, std::nullopt, std::hypot(model.own_sigma, model.good_sigma), is_3d, loss));
}

void FixMapper::begin_error(FixEntry& entry, const Decision& decision, const Place& place,
                            Contribution& out) {
  const ErrorMode mode = decision.mode;
  const FixModel model = model_of(entry);
  const std::uint64_t number = state_.errors++;
  Error next;
  next.key = Key(key_letter::kFixError, number);
  next.mode = {Key(key_letter::kFixErrorMode, number), kErrorModes};
  next.time = next.last_time = entry.fix.time;
  next.is_new = true;
  next.chosen = mode;
  const auto found = state_.newest.find(entry.receiver());
  const bool follows = place.error.has_value();
  const double time = follows ? std::max(kLeastTime, next.time - found->second.time) : 0;
  // Its estimate with all else held, as the first discrete half-step expects it.
  const bool continues = follows && goes_on(mode);
  const double variance =
      continues ? added_variance(model, time) : new_variance(model, is_biased(mode));
  const double gain =
      decision.is_false ? 0 : variance / (variance + model.own_sigma * model.own_sigma);
  next.value = continues ? Eigen::VectorXd(kept_share(model, time, is_biased(mode)) * *place.error)
                         : Eigen::VectorXd(Eigen::VectorXd::Zero(place.size));
  next.value += gain * (place.residual - next.value);
  const Key* const before = follows ? &found->second.key : nullptr;
  const DiscreteKey* const before_mode = follows ? &found->second.mode : nullptr;
  out.delta.hybrid.push_back(error_step(model, before, next.key, next.mode, time, place.size));
  out.delta.discrete.push_back(mode_table(model, before_mode, next.mode, time));
  insert_point(out.delta.values, next.key, padded_point(next.value), place.size == 3);
  out.delta.assignment.set(next.mode.key, static_cast<int>(mode));
  state_.newest[entry.receiver()] = std::move(next);
}

}  // namespace hybrid
