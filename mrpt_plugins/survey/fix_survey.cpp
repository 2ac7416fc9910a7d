// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/survey/fix_survey.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <utility>

#include "libhybrid/core/detail/quantile.h"
#include "mrpt_plugins/bridge/pose_conversions.h"

namespace hybrid {
namespace {

constexpr double kWorthACorrection = 0.02;  // s
constexpr const char* kReceiver = "receiver";

NoiseRecord measured_record(const char* sensor, const char* kind, const char* unit, double stated,
                            double measured) {
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

}  // namespace

void FixSurvey::add(const LogStep& step) {
  const double period = step.time - std::exchange(time_, step.time);
  if (step.odometry) {
    since_ = compose(since_, *step.odometry);
    const Eigen::Vector2d moved(step.odometry->mean.x(), step.odometry->mean.y());
    velocity_ = period > 0 ? Eigen::Vector2d(moved / period) : Eigen::Vector2d(0, 0);
  } else {
    is_broken_ = true;
  }
  for (const auto& observation : step.observations) {
    const auto fix = fix_in(*observation, dropped_);
    if (!fix || repeats_.is_repeated(fix->place)) continue;
    // Stamps that are far from the step are of another clock.
    const double early = fix->fix.time != 0 ? step.time - (fix->fix.time + clock_offset_) : 0;
    take(*fix, period > 0 && std::abs(early) <= 2 * period ? early : 0);
  }
}

void FixSurvey::take(const LoggedFix& fix, double early) {
  const auto position = datum_.to_local(fix, dropped_);
  if (datum_.is_contradicted()) {
    datum_ = {};
    fixes_.clear();
    is_broken_ = true;
  }
  if (!position) return;
  MovedFix out;
  out.time = time_;
  out.position = position->head<2>();
  out.sigma = fix.fix.sigma;
  out.antenna = fix.fix.antenna.head<2>() - early * velocity_;
  out.motion = to_se2(since_.mean);
  out.covariance = planar_part(since_.covariance);
  out.velocity = velocity_;
  out.begins = std::exchange(is_broken_, false);
  fixes_.push_back(std::move(out));
  since_ = {};
}

void measure_fixes(const FixModel& prior, bool tells_odometry, LogFindings& findings,
                   LogCorrection& correction) {
  if (!prior.modes) return;
  const ReceiverFit fit = fit_receiver(findings.fixes, prior);
  if (!fit.is_known) return;
  correction.receiver = std::make_shared<const FixModel>(fit.model);
  correction.fix_sigma_factor = fit.sigma_factor;
  if (std::abs(fit.delay) >= kWorthACorrection) correction.fix_delay = fit.delay;
  if (tells_odometry) {
    correction.translation *= fit.translation;
    correction.rotation *= fit.rotation;
    findings.noise.push_back(measured_record("odometry", "translation", "", 1, fit.translation));
    findings.noise.push_back(measured_record("odometry", "rotation", "", 1, fit.rotation));
  }
  const double stated = median_sigma(findings.fixes, prior.good_sigma);
  const FixModel& m = fit.model;
  findings.noise.push_back(
      measured_record(kReceiver, "own error", "m", prior.own_sigma, m.own_sigma));
  findings.noise.push_back(
      measured_record(kReceiver, "lasting error", "m", stated, stated * fit.sigma_factor));
  findings.remarks.push_back(fmt::format(
      "fixes as measured: errors of {:.2g} m that last {:.0f} s ({:.2g} m stated) and {:.2g} m of "
      "each one; runs of biased ones by {:.2g} m for {:.0f} s, every {:.0f} s; {:.2g} % false; "
      "{:.2g} s late{}",
      stated * fit.sigma_factor, m.lasts, stated, m.own_sigma, m.bias_sigma, m.bias_lasts,
      m.good_lasts, 100 * m.false_share, correction.fix_delay,
      tells_odometry ? fmt::format("; noise of the odometry {:.2g} times that stated along, {:.2g} "
                                   "times in turns",
                                   fit.translation, fit.rotation)
                     : ""));
}

}  // namespace hybrid
