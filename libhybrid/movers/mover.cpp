// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/movers/mover.h"

#include <Eigen/LU>
#include <algorithm>

#include "libhybrid/core/sort_unique.h"
#include "libhybrid/movers/motion_filter.h"

namespace hybrid {
namespace {

template <int D>
MoverState padded(double time, const typename VelocityState<D>::Mean& mean,
                  const typename VelocityState<D>::Covariance& covariance) {
  MoverState out;
  out.time = time;
  out.position.head<D>() = mean.template head<D>();
  out.velocity.head<D>() = mean.template tail<D>();
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      out.covariance.block<D, D>(3 * i, 3 * j) = covariance.template block<D, D>(D * i, D * j);
    }
  }
  return out;
}

/// The kind of motion that fits all sightings best.
template <int D>
MotionKind likeliest_kind(const std::vector<PointSighting>& sightings, const MotionPrior& prior) {
  MotionFilter<D> filter(sightings.front(), prior);
  // Births concern what stands alone.
  for (std::size_t i = 1; i < sightings.size(); ++i) filter.take(sightings[i], 1.0);
  return prior.kinds[filter.likeliest_kind()];
}

template <int D>
std::vector<MoverState> smoothed(const std::vector<PointSighting>& sightings,
                                 const std::vector<double>& wanted, const MotionPrior& prior) {
  std::vector<double> times = wanted;
  for (const PointSighting& s : sightings) times.push_back(s.time);
  sort_unique(times);
  const double first = sightings.front().time, last = sightings.back().time;
  times.erase(
      std::remove_if(times.begin(), times.end(), [&](double t) { return t < first || t > last; }),
      times.end());
  std::vector<VelocityState<D>> predicted, filtered;
  const MotionKind kind = likeliest_kind<D>(sightings, prior);
  VelocityState<D> state(sightings.front(), kind.speed);
  state.take_velocity(sightings.front());
  std::size_t next = 1;
  for (std::size_t k = 0; k < times.size(); ++k) {
    if (k > 0) state.predict(times[k] - times[k - 1], kind.acceleration);
    predicted.push_back(state);
    for (; next < sightings.size() && sightings[next].time <= times[k]; ++next) {
      state.take(sightings[next]);
    }
    filtered.push_back(state);
  }
  for (std::size_t k = times.size() - 1; k-- > 0;) {
    const VelocityState<D>& ahead = predicted[k + 1];
    const auto G = (filtered[k].covariance *
                    VelocityState<D>::transition(times[k + 1] - times[k]).transpose() *
                    ahead.covariance.inverse())
                       .eval();
    filtered[k].mean += G * (filtered[k + 1].mean - ahead.mean);
    filtered[k].covariance +=
        (G * (filtered[k + 1].covariance - ahead.covariance) * G.transpose()).eval();
  }
  std::vector<MoverState> out;
  for (const double t : wanted) {
    const auto at = std::lower_bound(times.begin(), times.end(), t);
    if (at == times.end() || *at != t) continue;
    const VelocityState<D>& s = filtered[static_cast<std::size_t>(at - times.begin())];
    out.push_back(padded<D>(t, s.mean, s.covariance));
  }
  return out;
}

}  // namespace

std::vector<MoverState> smoothed_states(const std::vector<PointSighting>& sightings,
                                        const std::vector<double>& times, const MotionPrior& prior,
                                        bool is_3d) {
  return is_3d ? smoothed<3>(sightings, times, prior) : smoothed<2>(sightings, times, prior);
}

}  // namespace hybrid
