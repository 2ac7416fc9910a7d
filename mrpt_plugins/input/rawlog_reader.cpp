// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/rawlog_reader.h"

#include <fmt/format.h>
#include <mrpt/core/Clock.h>
#include <mrpt/math/wrap2pi.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/system/datetime.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace hybrid {
namespace {

using mrpt::obs::CObservation;
using mrpt::obs::CObservationOdometry;
using mrpt::poses::CPose2D;

/// Observations that may wait for odometry after them, which a log without any never brings.
constexpr std::size_t kMaxWaiting = 256;

/// Times the usual period, beyond which frames are taken to be missing.
constexpr double kLongGap = 10;

CPose2D interpolate(const CPose2D& a, const CPose2D& b, double fraction) {
  const CPose2D step = b - a;
  return a + CPose2D(fraction * step.x(), fraction * step.y(), fraction * step.phi());
}

bool is_finite(const CPose2D& pose) {
  return std::isfinite(pose.x()) && std::isfinite(pose.y()) && std::isfinite(pose.phi());
}

}  // namespace

RawlogReader::RawlogReader(const std::string& path, const RawlogOptions& options)
    : objects_(path),
      options_(options),
      last_time_(-options.period),
      action_stamp_(INVALID_TIMESTAMP) {}

std::optional<LogStep> RawlogReader::next() {
  while (ready_.empty()) {
    const auto object = objects_.next();
    if (object) {
      take(object);
    } else if (!waiting_.empty()) {
      release_until(std::numeric_limits<double>::infinity());
    } else {
      return std::nullopt;
    }
  }
  LogStep step = std::move(ready_.front());
  ready_.pop_front();
  return step;
}

void RawlogReader::take(const mrpt::serialization::CSerializable::Ptr& object) {
  using mrpt::obs::CActionCollection;
  using mrpt::obs::CSensoryFrame;
  if (const auto actions = std::dynamic_pointer_cast<CActionCollection>(object)) {
    take_actions(*actions);
  } else if (const auto frame = std::dynamic_pointer_cast<CSensoryFrame>(object)) {
    take_frame(*frame);
  } else if (std::dynamic_pointer_cast<mrpt::obs::CObservationComment>(object)) {
    return;
  } else if (const auto odometry = std::dynamic_pointer_cast<CObservationOdometry>(object)) {
    take_odometry(*odometry);
  } else if (const auto observation = std::dynamic_pointer_cast<CObservation>(object)) {
    take_observation(observation);
  } else {
    ++warnings_[fmt::format("object ignored: {}", object->GetRuntimeClass()->className)];
  }
}

void RawlogReader::take_actions(const mrpt::obs::CActionCollection& actions) {
  if (actions.size() > 0) action_stamp_ = actions.get(0).timestamp;
  const auto motion = checked(odometry_of(actions));
  if (motion) motion_ = motion_ ? compose(*motion_, *motion) : *motion;
}

std::optional<OdometryIncrement> RawlogReader::checked(std::optional<OdometryIncrement> odometry) {
  if (!odometry) {
    ++warnings_["action without motion"];
  } else if (!is_sane(*odometry)) {
    ++warnings_["odometry dropped: not finite or covariance not valid"];
    odometry.reset();
  } else if (add_noise_floor(*odometry)) {
    ++warnings_["odometry repaired: noise of 1e-5 m or rad added where it had none"];
  }
  return odometry;
}

void RawlogReader::take_frame(const mrpt::obs::CSensoryFrame& frame) {
  LogStep step;
  auto stamp = INVALID_TIMESTAMP;
  std::optional<CPose2D> absolute;
  for (const auto& entry : frame) {
    const CObservation::Ptr& observation = entry;
    if (stamp == INVALID_TIMESTAMP) stamp = observation->timestamp;
    if (const auto* odometry = dynamic_cast<const CObservationOdometry*>(observation.get())) {
      absolute = odometry->odometry;
    } else {
      step.observations.push_back(observation);
    }
  }
  step.time = advance_to(time_of(stamp != INVALID_TIMESTAMP ? stamp : action_stamp_));
  action_stamp_ = INVALID_TIMESTAMP;
  if (motion_) {
    step.odometry = std::exchange(motion_, std::nullopt);
  } else if (absolute) {
    move_to(step, *absolute);
  }
  emit(std::move(step));
}

void RawlogReader::take_observation(const CObservation::Ptr& observation) {
  const double time = time_of(observation->timestamp);
  if (time < last_time_) {
    ++warnings_["observation dropped: time goes backwards"];
    return;
  }
  advance_to(time);
  if (!waiting_.empty() && waiting_.back().time == time) {
    waiting_.back().observations.push_back(observation);
    return;
  }
  if (after_) release_until(after_->time);
  if (waiting_.size() >= kMaxWaiting) release_front();
  LogStep step;
  step.time = time;
  step.observations.push_back(observation);
  waiting_.push_back(std::move(step));
}

void RawlogReader::take_odometry(const CObservationOdometry& odometry) {
  if (!is_finite(odometry.odometry)) {
    ++warnings_["odometry dropped: not finite or covariance not valid"];
    return;
  }
  const double time = time_of(odometry.timestamp);
  if (after_ && time < after_->time) {
    ++warnings_["odometry dropped: time goes backwards"];
    return;
  }
  before_ = after_;
  after_ = {time, odometry.odometry};
  // An observation with the very time of this odometry may still get company.
  release_until(std::nextafter(after_->time, 0.0));
}

void RawlogReader::release_until(double time) {
  while (!waiting_.empty() && waiting_.front().time <= time) release_front();
}

void RawlogReader::release_front() {
  LogStep step = std::move(waiting_.front());
  waiting_.pop_front();
  if (after_ && before_ && after_->time > before_->time) {
    const double fraction = (step.time - before_->time) / (after_->time - before_->time);
    move_to(step, interpolate(before_->pose, after_->pose, std::clamp(fraction, 0.0, 1.0)));
  } else if (after_) {
    move_to(step, after_->pose);
  }
  emit(std::move(step));
}

void RawlogReader::move_to(LogStep& step, const CPose2D& pose) {
  if (last_pose_)
    step.odometry = checked(odometry_between(*last_pose_, pose, options_.motion_model));
  last_pose_ = pose;
}

void RawlogReader::emit(LogStep step) {
  step.index = emitted_++;
  ready_.push_back(std::move(step));
}

double RawlogReader::time_of(mrpt::system::TTimeStamp stamp) {
  double time = last_time_ + options_.period;
  if (stamp == INVALID_TIMESTAMP) {
    ++warnings_["timestamp missing: synthesised"];
  } else {
    time = mrpt::Clock::toDouble(stamp);
  }
  return time;
}

double RawlogReader::advance_to(double time) {
  if (time < last_time_) {
    ++warnings_["timestamp repaired: it went backwards, that of the frame before taken"];
    return last_time_;
  }
  if (started_) {
    const double gap = time - last_time_;
    if (usual_gap_ > 0 && gap > kLongGap * usual_gap_) {
      ++warnings_["frames missing: a gap of over 10 times the usual period"];
    } else if (gap > 0) {
      usual_gap_ = usual_gap_ > 0 ? 0.9 * usual_gap_ + 0.1 * gap : gap;
    }
  }
  started_ = true;
  return last_time_ = time;
}

}  // namespace hybrid
