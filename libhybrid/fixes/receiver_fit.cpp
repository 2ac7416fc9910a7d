// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/fixes/receiver_fit.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "libhybrid/core/infinity.h"
#include "libhybrid/fixes/datum_alignment.h"

namespace hybrid {
namespace {

constexpr std::size_t kFewest = 30;                    // fixes
constexpr std::size_t kStretches = 4, kStretch = 500;  // of which, and of so many fixes, count
constexpr std::size_t kMostToAlign = 200;              // fixes
constexpr double kNorthSigma = 0.1;                    // rad, sigma of the direction of north
constexpr double kPriorFactor = 1;                     // sigma of the logarithm
constexpr double kReceiverFactor = 0.5;                // the same of lasting errors
constexpr double kPriorDelay = 0.3;                    // s
constexpr double kLeastBias = 2;  // of the sigma that a receiver states: less is no bias
constexpr double kFirstStep = 0.7, kLastStep = 0.05;  // of logarithms
constexpr double kLastDelay = 1e-3;                   // s, the last step of the delay
constexpr double kSureOfDelay = 4.5;  // nats over none, those of three standard deviations

using State = Eigen::Matrix<double, 5, 1>;  // x, y, yaw, error
using Covariance = Eigen::Matrix<double, 5, 5>;

/// What is measured, by the logarithm of its factor; the delay by itself.
struct Parameters {
  enum {
    kOwn,
    kGood,
    kLasts,
    kRenewed,
    kBias,
    kGoodLasts,
    kBiasLasts,
    kFalse,
    kAlong,
    kTurn,
    kDelay,
    kCount
  };
  std::array<double, kCount> x{};

  double factor(int i) const { return std::exp(x[static_cast<std::size_t>(i)]); }
  double delay() const { return x[kDelay]; }
  /// The prior, as a log density up to a constant.
  double log_prior() const {
    double sum = std::pow(delay() / kPriorDelay, 2);
    for (int i = 0; i < kDelay; ++i) {
      const double sigma = i == kGood || i == kLasts ? kReceiverFactor : kPriorFactor;
      sum += std::pow(x[static_cast<std::size_t>(i)] / sigma, 2);
    }
    return -0.5 * sum;
  }
  FixModel model(const FixModel& prior) const {
    FixModel out = prior;
    out.own_sigma *= factor(kOwn);
    out.good_sigma *= factor(kGood);
    out.lasts *= factor(kLasts);
    out.renewed *= factor(kRenewed);
    out.bias_sigma = std::max(kLeastBias * prior.good_sigma, out.bias_sigma * factor(kBias));
    out.good_lasts *= factor(kGoodLasts);
    out.bias_lasts *= factor(kBiasLasts);
    out.false_share = std::min(0.5, out.false_share * factor(kFalse));
    return out;
  }
};

/// A Gaussian and the logarithm of its weight.
struct Part {
  double log_weight = -kInfinity;
  State mean = State::Zero();
  Covariance P = Covariance::Identity();
};

double log_sum(double a, double b) {
  const double most = std::max(a, b);
  if (most == -kInfinity) return most;
  return most + std::log(std::exp(a - most) + std::exp(b - most));
}

/// A sum of Gaussians is replaced by one of the same mean and covariance, part by part.
class Merge {
 public:
  void add(const Part& part) {
    if (part.log_weight == -kInfinity) return;
    if (log_weight_ == -kInfinity) {
      log_weight_ = part.log_weight;
      mean_ = part.mean;
      P_ = part.P;
      return;
    }
    const double both = log_sum(log_weight_, part.log_weight);
    const double share = std::exp(part.log_weight - both);
    State off = part.mean - mean_;
    off[2] = std::remainder(off[2], 2 * M_PI);
    P_ = (1 - share) * P_ + share * part.P + share * (1 - share) * off * off.transpose();
    mean_ += share * off;
    log_weight_ = both;
  }
  Part get() const { return {log_weight_, mean_, P_}; }

 private:
  double log_weight_ = -kInfinity;
  State mean_ = State::Zero();
  Covariance P_ = Covariance::Identity();
};

/// Along one stretch of fixes.
class Filter {
 public:
  Filter(const Parameters& parameters, const FixModel& prior)
      : parameters_(parameters), model_(parameters.model(prior)) {}

  /// Begins where an alignment says that the robot was before the first fix.
  void begin(const SE2& pose) {
    for (int biased = 0; biased < 2; ++biased) {
      Part& part = parts_[static_cast<std::size_t>(biased)];
      part.log_weight = biased == 0 ? 0 : -kInfinity;
      part.mean << pose.translation(), pose.angle(), 0, 0;
      part.P = State(100, 100, 0.1, 0, 0).asDiagonal();
    }
    is_first_ = true;
  }

  /// The log density of a fix given those before.
  double take(const MovedFix& fix) {
    FixModel model = model_;
    if (fix.sigma > 0) model.good_sigma = fix.sigma * parameters_.factor(Parameters::kGood);
    const double time = std::max(1e-3, fix.time - time_);
    std::array<Merge, 2> next;
    for (int before = 0; before < 2; ++before) {
      Part part = parts_[static_cast<std::size_t>(before)];
      if (part.log_weight == -kInfinity) continue;
      if (!is_first_) move(fix, part);
      const auto past = before == 0 ? ErrorMode::kGood : ErrorMode::kBiased;
      for (int i = 0; i < kErrorModes; ++i) {
        const auto mode = static_cast<ErrorMode>(i);
        const double cost = mode_cost(model, is_first_ ? nullptr : &past, mode, time);
        if (cost == kInfinity) continue;
        Part in_mode = part;
        in_mode.log_weight -= cost;
        add(fix, model, in_mode, mode, time, next[is_biased(mode) ? 1 : 0]);
      }
    }
    return close(fix, next);
  }

 private:
  void move(const MovedFix& fix, Part& part) const {
    const double c = std::cos(part.mean[2]), s = std::sin(part.mean[2]);
    const Eigen::Vector2d t = fix.motion.translation();
    const Eigen::Vector2d moved(c * t.x() - s * t.y(), s * t.x() + c * t.y());
    Covariance F = Covariance::Identity();
    F(0, 2) = -moved.y();
    F(1, 2) = moved.x();
    part.mean.head<2>() += moved;
    part.mean[2] += fix.motion.angle();
    part.P = F * part.P * F.transpose();
    const double along = parameters_.factor(Parameters::kAlong);
    const Eigen::Vector3d factors(along, along, parameters_.factor(Parameters::kTurn));
    Eigen::Matrix3d Q = factors.asDiagonal() * fix.covariance * factors.asDiagonal();
    const double yaw = part.mean[2];
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    R.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(yaw).toRotationMatrix();
    part.P.topLeftCorner<3, 3>() += R * Q * R.transpose();
  }

  /// A mode of the error, right or false.
  void add(const MovedFix& fix, const FixModel& model, Part part, ErrorMode mode, double time,
           Merge& into) const {
    const double kept = !is_first_ && goes_on(mode) ? kept_share(model, time, is_biased(mode)) : 0;
    const double added = !is_first_ && goes_on(mode) ? added_variance(model, time)
                                                     : new_variance(model, is_biased(mode));
    part.mean.tail<2>() *= kept;
    part.P.rightCols<2>() *= kept;
    part.P.bottomRows<2>() *= kept;
    part.P.bottomRightCorner<2, 2>().diagonal().array() += added;
    Part wrong = part;
    wrong.log_weight += std::log(model.false_share) - 2 * std::log(model.false_reach);
    into.add(wrong);
    part.log_weight += std::log(1 - model.false_share) + update(fix, model, part);
    into.add(part);
  }

  /// By a right fix; returns the log of its density.
  double update(const MovedFix& fix, const FixModel& model, Part& part) const {
    const double c = std::cos(part.mean[2]), s = std::sin(part.mean[2]);
    const Eigen::Vector2d lever = fix.antenna - parameters_.delay() * fix.velocity;
    const Eigen::Vector2d at(c * lever.x() - s * lever.y(), s * lever.x() + c * lever.y());
    Eigen::Matrix<double, 2, 5> H;
    H << 1, 0, -at.y(), 1, 0, 0, 1, at.x(), 0, 1;
    const Eigen::Vector2d v = fix.position - part.mean.head<2>() - at - part.mean.tail<2>();
    const Eigen::Matrix<double, 5, 2> PH = part.P * H.transpose();
    Eigen::Matrix2d S = H * PH;
    S.diagonal().array() += model.own_sigma * model.own_sigma;
    const Eigen::Matrix2d inverse = S.inverse();
    const Eigen::Matrix<double, 5, 2> K = PH * inverse;
    part.mean += K * v;
    part.P -= K * PH.transpose();
    part.P = (0.5 * (part.P + part.P.transpose())).eval();
    return -0.5 * (v.dot(inverse * v) + std::log(S.determinant())) - std::log(2 * M_PI);
  }

  double close(const MovedFix& fix, const std::array<Merge, 2>& next) {
    for (std::size_t i = 0; i < 2; ++i) parts_[i] = next[i].get();
    const double all = log_sum(parts_[0].log_weight, parts_[1].log_weight);
    for (Part& part : parts_) part.log_weight -= all;
    time_ = fix.time;
    is_first_ = false;
    return all;
  }

  const Parameters& parameters_;
  FixModel model_;
  std::array<Part, 2> parts_;
  double time_ = 0;
  bool is_first_ = true;
};

/// Fixes that follow each other, and where the robot was when the first came.
struct Stretch {
  std::vector<MovedFix> fixes;
  SE2 start;
};

/// Finds the start of a stretch; nothing where fixes do not tell the direction.
std::optional<SE2> start_of(const std::vector<MovedFix>& fixes, const FixModel& prior) {
  std::vector<DatumPair> pairs;
  SE2 pose;
  for (std::size_t i = 0; i < std::min(fixes.size(), kMostToAlign); ++i) {
    if (i > 0) pose = pose * fixes[i].motion;
    DatumPair pair;
    pair.in_map << pose * fixes[i].antenna, 0;
    pair.in_datum << fixes[i].position, 0;
    pair.sigma = fixes[i].sigma > 0 ? fixes[i].sigma : prior.good_sigma;
    pairs.push_back(pair);
  }
  const auto T = align_to_datum(pairs, kNorthSigma);
  if (!T) return std::nullopt;
  return SE2(T->translation().x(), T->translation().y(),
             std::atan2(T->linear()(1, 0), T->linear()(0, 0)));
}

/// Up to kStretches stretches, evenly spread over the fixes.
std::vector<Stretch> stretches_of(const std::vector<MovedFix>& fixes, const FixModel& prior) {
  std::vector<Stretch> out;
  const std::size_t parts = std::min(kStretches, std::max<std::size_t>(1, fixes.size() / kStretch));
  for (std::size_t k = 0; k < parts; ++k) {
    const std::size_t from = fixes.size() * k / parts;
    std::size_t to = std::min({fixes.size(), from + kStretch, fixes.size() * (k + 1) / parts});
    for (std::size_t i = from + 1; i < to; ++i) {
      if (fixes[i].begins) to = i;
    }
    Stretch next{{fixes.begin() + static_cast<std::ptrdiff_t>(from),
                  fixes.begin() + static_cast<std::ptrdiff_t>(to)},
                 {}};
    if (next.fixes.size() < kFewest) continue;
    const auto start = start_of(next.fixes, prior);
    if (!start) continue;
    next.start = *start;
    out.push_back(std::move(next));
  }
  return out;
}

double log_posterior(const std::vector<Stretch>& stretches, const Parameters& parameters,
                     const FixModel& prior) {
  double sum = parameters.log_prior();
  for (const Stretch& stretch : stretches) {
    Filter filter(parameters, prior);
    filter.begin(stretch.start);
    for (const MovedFix& fix : stretch.fixes) sum += filter.take(fix);
  }
  return std::isfinite(sum) ? sum : -kInfinity;
}

/// Searches for the most probable parameters along one after another, by steps that become smaller.
class Search {
 public:
  Search(const std::vector<Stretch>& stretches, const FixModel& prior, const Parameters& start)
      : stretches_(stretches),
        prior_(prior),
        best_(start),
        most_(log_posterior(stretches, start, prior)) {}

  /// All parameters, or all but the delay.
  void along_all(bool with_delay) {
    for (double share = 1; share * kFirstStep > kLastStep; share /= 2) {
      for (bool improved = true; improved;) {
        improved = false;
        for (std::size_t i = 0; i < best_.x.size(); ++i) {
          const bool is_delay = i == Parameters::kDelay;
          if (is_delay && !with_delay) continue;
          improved = along(i, share * kFirstStep * (is_delay ? kPriorDelay : 1)) || improved;
        }
      }
    }
  }
  /// The delay alone.
  void along_delay() {
    for (double step = kLastStep * kPriorDelay; step > kLastDelay; step /= 2) {
      while (along(Parameters::kDelay, step)) {
      }
    }
  }

  const Parameters& best() const { return best_; }
  double log_probability() const { return most_; }

 private:
  /// One step either way; false where neither is better.
  bool along(std::size_t i, double step) {
    for (const double to : {step, -step}) {
      Parameters tried = best_;
      tried.x[i] += to;
      const double value = log_posterior(stretches_, tried, prior_);
      if (!(value > most_ + 1e-3)) continue;
      most_ = value;
      best_ = tried;
      return true;
    }
    return false;
  }

  const std::vector<Stretch>& stretches_;
  const FixModel& prior_;
  Parameters best_;
  double most_;
};

/// The most probable parameters, with a delay where fixes are sure of one.
Parameters most_probable(const std::vector<Stretch>& stretches, const FixModel& prior) {
  Search all(stretches, prior, {});
  all.along_all(true);
  all.along_delay();
  Parameters punctual = all.best();
  punctual.x[Parameters::kDelay] = 0;
  Search without(stretches, prior, punctual);
  without.along_all(false);
  const bool is_sure = all.log_probability() > without.log_probability() + kSureOfDelay;
  return is_sure ? all.best() : without.best();
}

}  // namespace

ReceiverFit fit_receiver(const std::vector<MovedFix>& fixes, const FixModel& prior) {
  ReceiverFit out;
  out.model = prior;
  const std::vector<Stretch> stretches = stretches_of(fixes, prior);
  if (stretches.empty()) return out;
  const Parameters found = most_probable(stretches, prior);
  out.model = found.model(prior);
  out.sigma_factor = found.factor(Parameters::kGood);
  out.translation = found.factor(Parameters::kAlong);
  out.rotation = found.factor(Parameters::kTurn);
  out.delay = found.delay();
  out.is_known = true;
  return out;
}

}  // namespace hybrid
