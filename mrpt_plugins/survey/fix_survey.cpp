// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/survey/fix_survey.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "libhybrid/core/quantile.h"
#include "mrpt_plugins/bridge/pose_conversions.h"

namespace hybrid {
namespace {

constexpr double kWorthACorrection = 0.02;  // s

NoiseRecord measured_record(const std::string& sensor, const char* kind, const char* unit,
                            double stated, double measured) {
  NoiseRecord out;
  out.sensor = sensor;
  out.kind = kind;
  out.unit = unit;
  out.stated = stated;
  out.measured = out.used = measured;
  return out;
}

double median_sigma(const std::vector<MovedFix>& fixes, double unstated) {
  std::vector<double> sigmas;
  for (const MovedFix& fix : fixes) sigmas.push_back(fix.sigma > 0 ? fix.sigma : unstated);
  return median(std::move(sigmas));
}

/// What a fit tells of a receiver, which is called `name`.
void describe(const std::string& name, const FixModel& prior, double stated, const ReceiverFit& fit,
              double delay, LogFindings& findings) {
  const FixModel& m = fit.model;
  findings.noise.push_back(measured_record(name, "own error", "m", prior.own_sigma, m.own_sigma));
  findings.noise.push_back(
      measured_record(name, "lasting error", "m", stated, stated * fit.sigma_factor));
  findings.remarks.push_back(fmt::format(
      "{} as measured: errors of {:.2g} m that last {:.0f} s ({:.2g} m stated) and {:.2g} m of "
      "each fix; runs of biased ones by {:.2g} m for {:.0f} s, every {:.0f} s; {:.2g} % false; "
      "{:.2g} s late",
      name, stated * fit.sigma_factor, m.lasts, stated, m.own_sigma, m.bias_sigma, m.bias_lasts,
      m.good_lasts, 100 * m.false_share, delay));
}

/// The same of the odometry.
void describe_odometry(const ReceiverFit& fit, LogFindings& findings) {
  findings.noise.push_back(measured_record("odometry", "translation", "", 1, fit.translation));
  findings.noise.push_back(measured_record("odometry", "rotation", "", 1, fit.rotation));
  findings.remarks.push_back(
      fmt::format("odometry by fixes: noise {:.2g} times that stated along, {:.2g} times in turns",
                  fit.translation, fit.rotation));
}

}  // namespace

void FixSurvey::add(const LogStep& step) {
  const double period = step.time - std::exchange(time_, step.time);
  if (step.odometry) {
    for (auto& [label, track] : tracks_) track.since = compose(track.since, *step.odometry);
    const Eigen::Vector2d moved(step.odometry->mean.x(), step.odometry->mean.y());
    velocity_ = period > 0 ? Eigen::Vector2d(moved / period) : Eigen::Vector2d(0, 0);
  } else {
    for (auto& [label, track] : tracks_) track.is_broken = true;
  }
  for (const auto& observation : step.observations) {
    const auto fix = fix_in(*observation, dropped_);
    if (!fix || repeats_.is_repeated(*fix)) continue;
    // Stamps that are far from the step are of another clock.
    const double early = fix->fix.time != 0 ? step.time - (fix->fix.time + clock_offset_) : 0;
    take(*fix, period > 0 && std::abs(early) <= 2 * period ? early : 0);
  }
}

void FixSurvey::take(const LoggedFix& fix, double early) {
  const auto position = datum_.to_local(fix, dropped_);
  if (datum_.is_contradicted()) {
    datum_ = {};
    tracks_.clear();
  }
  if (!position) return;
  Track& track = tracks_[fix.fix.sensor];
  MovedFix out;
  out.time = time_;
  out.position = position->head<2>();
  out.sigma = fix.fix.sigma;
  out.antenna = fix.fix.antenna.head<2>() - early * velocity_;
  out.motion = to_se2(track.since.mean);
  out.covariance = planar_part(track.since.covariance);
  out.velocity = velocity_;
  out.begins = std::exchange(track.is_broken, false);
  track.fixes.push_back(std::move(out));
  track.since = {};
}

std::map<std::string, std::vector<MovedFix>> FixSurvey::release() {
  std::map<std::string, std::vector<MovedFix>> out;
  for (auto& [label, track] : tracks_) out[label] = std::move(track.fixes);
  tracks_.clear();
  return out;
}

void measure_fixes(const FixModel& prior, bool tells_odometry, LogFindings& findings,
                   LogCorrection& correction) {
  if (!prior.modes) return;
  std::size_t most = 0;
  std::optional<ReceiverFit> longest;
  for (const auto& [label, fixes] : findings.fixes) {
    const ReceiverFit fit = fit_receiver(fixes, prior);
    if (!fit.is_known) continue;
    const double delay = std::abs(fit.delay) >= kWorthACorrection ? fit.delay : 0;
    correction.receivers[label] = {std::make_shared<const FixModel>(fit.model), fit.sigma_factor,
                                   delay};
    const std::string name = findings.fixes.size() == 1 ? "receiver" : "receiver " + label;
    describe(name, prior, median_sigma(fixes, prior.good_sigma), fit, delay, findings);
    if (fixes.size() <= most) continue;
    most = fixes.size();
    longest = fit;
  }
  if (!longest || !tells_odometry) return;
  correction.translation *= longest->translation;
  correction.rotation *= longest->rotation;
  describe_odometry(*longest, findings);
}

}  // namespace hybrid
