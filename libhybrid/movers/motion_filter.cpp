// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/movers/motion_filter.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "libhybrid/association/gate.h"

namespace hybrid {
namespace {

/// log N(r; 0, S).
double log_gaussian(const Eigen::VectorXd& r, const Eigen::MatrixXd& S) {
  return -gaussian_score(r, S).cost;
}

/// log(exp(a) + exp(b)).
double log_sum(double a, double b) {
  const double top = std::max(a, b);
  return top + std::log1p(std::exp(std::min(a, b) - top));
}

/// log p of a measured velocity where it is noise alone; 0 where none was measured.
template <int D>
double log_at_rest(const PointSighting& seen) {
  if (!seen.has_velocity) return 0;
  const Eigen::Matrix<double, D, 1> v = seen.velocity.head<D>();
  const Eigen::Matrix<double, D, D> R = seen.velocity_covariance.topLeftCorner<D, D>();
  return log_gaussian(v, R);
}

/// Takes a measurement z = H x of covariance R into a state; returns log p(z).
template <class State, class H, class Z, class R>
double update(State& state, const H& h, const Z& z, const R& noise) {
  const R S = h * state.covariance * h.transpose() + noise;
  const Z innovation = z - h * state.mean;
  const double log_p = log_gaussian(innovation, S);
  const auto gain = (state.covariance * h.transpose() * S.inverse()).eval();
  state.mean += gain * innovation;
  // Joseph's form stays symmetric and positive definite.
  using Covariance = typename State::Covariance;
  const Covariance rest = Covariance::Identity() - gain * h;
  state.covariance =
      (rest * state.covariance * rest.transpose() + gain * noise * gain.transpose()).eval();
  return log_p;
}

}  // namespace

template <int D>
VelocityState<D>::VelocityState(const PointSighting& seen, double speed) {
  mean.setZero();
  covariance.setZero();
  mean.template head<D>() = seen.point.head<D>();
  covariance.template topLeftCorner<D, D>() = seen.covariance.topLeftCorner<D, D>();
  covariance.template bottomRightCorner<D, D>().diagonal().setConstant(speed * speed);
}

template <int D>
typename VelocityState<D>::Covariance VelocityState<D>::transition(double dt) {
  Covariance F = Covariance::Identity();
  F.template topRightCorner<D, D>().diagonal().setConstant(dt);
  return F;
}

template <int D>
void VelocityState<D>::predict(double dt, double acceleration) {
  if (!(dt > 0)) return;
  const Covariance F = transition(dt);
  const double q = acceleration * acceleration;
  mean = (F * mean).eval();
  covariance = (F * covariance * F.transpose()).eval();
  for (int i = 0; i < D; ++i) {
    covariance(i, i) += q * dt * dt * dt / 3;
    covariance(i, D + i) += q * dt * dt / 2;
    covariance(D + i, i) += q * dt * dt / 2;
    covariance(D + i, D + i) += q * dt;
  }
}

template <int D>
double VelocityState<D>::take(const PointSighting& seen) {
  if (!seen.has_velocity) {
    const Eigen::Matrix<double, D, 2 * D> H = Eigen::Matrix<double, D, 2 * D>::Identity();
    const Eigen::Matrix<double, D, 1> z = seen.point.head<D>();
    const Eigen::Matrix<double, D, D> R = seen.covariance.topLeftCorner<D, D>();
    return update(*this, H, z, R);
  }
  Mean z;
  z << seen.point.head<D>(), seen.velocity.head<D>();
  Covariance R = Covariance::Zero();
  R.template topLeftCorner<D, D>() = seen.covariance.topLeftCorner<D, D>();
  R.template bottomRightCorner<D, D>() = seen.velocity_covariance.topLeftCorner<D, D>();
  const Covariance H = Covariance::Identity();
  return update(*this, H, z, R);
}

template <int D>
double VelocityState<D>::take_velocity(const PointSighting& seen) {
  if (!seen.has_velocity) return 0;
  Eigen::Matrix<double, D, 2 * D> H = Eigen::Matrix<double, D, 2 * D>::Zero();
  H.template rightCols<D>().setIdentity();
  const Eigen::Matrix<double, D, 1> z = seen.velocity.head<D>();
  const Eigen::Matrix<double, D, D> R = seen.velocity_covariance.topLeftCorner<D, D>();
  return update(*this, H, z, R);
}

template <int D>
MotionFilter<D>::MotionFilter(const PointSighting& first, const MotionPrior& prior)
    : time_(first.time),
      standing_(first.point.head<D>()),
      standing_covariance_(first.covariance.topLeftCorner<D, D>()),
      standing_evidence_(log_at_rest<D>(first)) {
  for (const MotionKind& kind : prior.kinds) {
    Motion motion{VelocityState<D>(first, kind.speed), kind.acceleration, 0};
    motion.evidence = motion.state.take_velocity(first);
    motions_.push_back(motion);
  }
}

template <int D>
double MotionFilter<D>::evidence() const {
  double sum = motions_.front().evidence;
  for (std::size_t k = 1; k < motions_.size(); ++k) sum = log_sum(sum, motions_[k].evidence);
  return sum - std::log(static_cast<double>(motions_.size())) - standing_evidence_;
}

template <int D>
std::size_t MotionFilter<D>::likeliest_kind() const {
  const auto best =
      std::max_element(motions_.begin(), motions_.end(),
                       [](const Motion& a, const Motion& b) { return a.evidence < b.evidence; });
  return static_cast<std::size_t>(best - motions_.begin());
}

/// log p of a sighting of the thing where it stands.
template <int D>
double MotionFilter<D>::log_standing(const PointSighting& seen) const {
  const Covariance R = seen.covariance.topLeftCorner<D, D>();
  return log_gaussian(seen.point.head<D>() - standing_, R + standing_covariance_) +
         log_at_rest<D>(seen);
}

template <int D>
void MotionFilter<D>::take(const PointSighting& seen, double births) {
  for (Motion& motion : motions_) {
    motion.state.predict(seen.time - time_, motion.acceleration);
    motion.evidence += motion.state.take(seen);
  }
  time_ = std::max(time_, seen.time);
  const Covariance R = seen.covariance.topLeftCorner<D, D>();
  const double same = log_standing(seen);
  const double another = std::log(births) + log_at_rest<D>(seen);
  standing_evidence_ += log_sum(same, another);
  if (same < another) {
    standing_ = seen.point.head<D>();
    standing_covariance_ = R;
    return;
  }
  const Covariance gain = standing_covariance_ * (standing_covariance_ + R).inverse();
  standing_ += gain * (seen.point.head<D>() - standing_);
  standing_covariance_ = (gain * R).eval();
}

template <int D>
double MotionFilter<D>::log_density(const PointSighting& seen, double moving) const {
  // Sums over the modes: of their probabilities so far, and of these times the densities.
  double weights = std::log1p(-moving) + standing_evidence_;
  double densities = weights + log_standing(seen);
  const double share = std::log(moving / static_cast<double>(motions_.size()));
  for (const Motion& motion : motions_) {
    VelocityState<D> state = motion.state;
    state.predict(seen.time - time_, motion.acceleration);
    weights = log_sum(weights, share + motion.evidence);
    densities = log_sum(densities, share + motion.evidence + state.take(seen));
  }
  return densities - weights;
}

double log_odds_of_motion(double evidence, double moving) {
  return evidence + std::log(moving) - std::log1p(-moving);
}

template struct VelocityState<2>;
template struct VelocityState<3>;
template class MotionFilter<2>;
template class MotionFilter<3>;

}  // namespace hybrid
