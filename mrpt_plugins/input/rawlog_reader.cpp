// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/rawlog_reader.h"

#include <fmt/format.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/system/datetime.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "libhybrid/io/escaped.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/bridge/standard_input.h"
#include "mrpt_plugins/mrpt_version.h"

namespace hybrid {
namespace {

using mrpt::obs::CObservationOdometry;
using mrpt::obs::CObservationRobotPose;
using mrpt::poses::CPose2D;
using mrpt::poses::CPose3D;

/// Limit of observations that wait for later odometry, for logs without any.
constexpr std::size_t kMaxWaiting = 256;

constexpr const char* kTooFar =
    "odometry dropped: farther, or less certain, than [reader] max_speed allows";

/// Multiple of the usual period beyond which frames count as missing.
constexpr double kLongGap = 10;

/// Share of odometry readings with a stamp of others from which the clock is too coarse.
constexpr double kCoarseClock = 0.5;

/// Adds the content and points of an observation to a step.
void add(const LoggedObservation& observation, LogStep& step) {
  if (observation.content) step.observations.push_back(observation.content);
  step.points.insert(step.points.end(), observation.points.begin(), observation.points.end());
}

bool is_finite(const CPose2D& pose) {
  return std::isfinite(pose.x()) && std::isfinite(pose.y()) && std::isfinite(pose.phi());
}

}  // namespace

RawlogReader::RawlogReader(const std::string& path, const RawlogOptions& options)
    : objects_(path, options.request, options.libraries),
      options_(options),
      last_time_(-options.period),
      action_stamp_(INVALID_TIMESTAMP),
      arrivals_(is_standard_input(path) ? 0 : options.arrival_window) {}

std::optional<LogStep> RawlogReader::next() {
  while (ready_.empty()) {
    const auto object = objects_.next();
    if (object) {
      std::visit([this](const auto& kind) { take(kind); }, *object);
    } else if (drain(true); !waiting_.empty()) {
      release_until(std::numeric_limits<double>::infinity());
    } else if (ready_.empty() && emitted_ == 0 && unused_) {
      ready_.emplace_back().time = *unused_;
      ++emitted_;
    } else if (ready_.empty()) {
      note_action();
      return std::nullopt;
    }
  }
  LogStep step = std::move(ready_.front());
  ready_.pop_front();
  return step;
}

std::vector<PoseBetween> RawlogReader::rest() const {
  std::vector<PoseBetween> out = between_.rest();
  return out.empty() ? actions_.rest() : out;
}

void RawlogReader::take(const OtherObject& other) {
  ++warnings_[fmt::format("object ignored: {}", escaped(other.class_name))];
}

void RawlogReader::take(const LoggedActions& actions) {
  note_action();
  if (actions.time != INVALID_TIMESTAMP) action_stamp_ = actions.time;
  const auto told = odometry_of(actions.motion);
  const auto motion = checked(told);
  if (motion) motion_ = motion_ ? compose(*motion_, *motion) : *motion;
  if (told && !motion) motion_is_known_ = false;
}

/// Where the actions since the last frame have led so far.
void RawlogReader::note_action() {
  if (!motion_ || !motion_is_known_ || action_stamp_ == INVALID_TIMESTAMP) return;
  actions_.add(seconds_of(action_stamp_) + options_.clock_offset,
               T_start_frame_ * to_isometry(motion_->mean));
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

void RawlogReader::take(const LoggedFrame& frame) {
  drain(true);
  LogStep step;
  auto stamp = INVALID_TIMESTAMP;
  std::optional<OdometryReading> absolute;
  for (const LoggedObservation& observation : frame.observations) {
    ++observations_[escaped(without_namespace(observation.class_name))];
    if (stamp == INVALID_TIMESTAMP) stamp = observation.time;
    if (const auto pose = pose_in(observation)) {
      absolute = pose;
    } else {
      add(observation, step);
    }
  }
  step.time = advance_to(time_of(stamp != INVALID_TIMESTAMP ? stamp : action_stamp_));
  action_stamp_ = INVALID_TIMESTAMP;
  if (!motion_is_known_) motion_.reset();
  motion_is_known_ = true;
  if (motion_ || !absolute) {
    move_by_actions(step);
  } else {
    move_to(step, *absolute);
  }
  if (step.odometry && (step.between.empty() || step.between.back().time < step.time)) {
    step.between.push_back({step.time, Eigen::Isometry3d::Identity()});
  }
  emit(std::move(step));
}

/// Moves to a frame by the actions before it. Where the frame has a reading of its own time, the
/// readings since the last one tell where the robot was between, else the actions.
void RawlogReader::move_by_actions(LogStep& step) {
  step.odometry = std::exchange(motion_, std::nullopt);
  if (step.odometry) {
    acts_ = true;
    T_start_frame_ = T_start_frame_ * to_isometry(step.odometry->mean);
    stop_.take(step.time, to_isometry(step.odometry->mean));
  } else {
    actions_.lose(step.time);
    between_.lose(step.time);
  }
  step.between = actions_.to(step.time, T_start_frame_);
  if (!after_ || after_->time != step.time) {
    between_.lose(step.time);
    return;
  }
  std::vector<PoseBetween> read = between_.to(step.time, after_->pose.isometry());
  if (!read.empty()) step.between = std::move(read);
}

void RawlogReader::take(const LoggedObservation& observation) {
  static const std::string kComment = CLASS_ID(mrpt::obs::CObservationComment)->className;
  ++observations_[escaped(without_namespace(observation.class_name))];
  if (observation.class_name == kComment) return;
  const bool is_stamped = observation.time != INVALID_TIMESTAMP;
  const double time =
      is_stamped ? seconds_of(observation.time) : arrivals_.newest().value_or(last_time_);
  if (!observation.content && observation.points.empty()) {
    if (!unused_) unused_ = time + options_.clock_offset;
    return;
  }
  arrivals_.add(time, observation);
  drain(false);
}

/// Takes what nothing can come before any more, or `all` that has arrived.
void RawlogReader::drain(bool all) {
  while (const auto observation = arrivals_.next(all)) take_in_order(*observation);
}

void RawlogReader::take_in_order(const LoggedObservation& observation) {
  if (const auto pose = pose_in(observation)) {
    take_odometry(observation.time, *pose);
    return;
  }
  if (dynamic_cast<const CObservationRobotPose*>(observation.content.get()) != nullptr) return;
  const double time = time_of(observation.time);
  if (started_ && time < last_time_) {
    ++warnings_["observation dropped: time goes backwards"];
    return;
  }
  advance_to(time);
  if (waiting_.empty() || waiting_.back().time != time) {
    if (after_) release_until(after_->time);
    if (waiting_.size() >= kMaxWaiting) release_front();
    waiting_.emplace_back().time = time;
  }
  add(observation, waiting_.back());
}

/// The pose by odometry that an observation tells. That of the robot counts where the log has no
/// other; where another begins, what is known so far is in another frame.
std::optional<OdometryReading> RawlogReader::pose_in(const LoggedObservation& observation) {
  const auto* content = observation.content.get();
  if (const auto* odometry = dynamic_cast<const CObservationOdometry*>(content)) {
    if (!has_odometry_ && after_) start_odometry_anew();
    has_odometry_ = true;
    return OdometryReading{odometry->odometry, std::nullopt};
  }
  const auto* seen = dynamic_cast<const CObservationRobotPose*>(content);
  if (seen == nullptr || has_odometry_) return std::nullopt;
  const CPose3D& pose = seen->pose.mean;
  OdometryReading out{CPose2D(pose), std::nullopt};
  if (!is_planar(pose) || (last_pose_ && last_pose_->space)) out.space = pose;
  return out;
}

void RawlogReader::take_odometry(mrpt::system::TTimeStamp stamp, const OdometryReading& pose) {
  if (!is_finite(pose.plane) || !pose.position().allFinite()) {
    ++warnings_["odometry dropped: not finite or covariance not valid"];
    return;
  }
  const double time = time_of(stamp);
  if (after_ && time < after_->time) {
    ++warnings_["odometry dropped: time goes backwards"];
    return;
  }
  ++readings_;
  if (after_ && time == after_->time) {
    ++repeated_;
    moves_at_once_ = moves_at_once_ || pose.position() != after_->pose.position();
  }
  if (reset_.at(pose.position())) {
    ++warnings_[OdometryReset::kDropped];
    start_odometry_anew();
  }
  has_gap_ = !acts_ && gap_.before(time, pose.isometry());  // beside actions there may be few
  if (has_gap_) ++warnings_[OdometryGap::kMissing];
  if (!acts_ && after_) stop_.take(time, after_->pose.isometry().inverse() * pose.isometry());
  before_ = after_;
  if (after_ && !is_within_reach(*after_, {time, pose})) between_.lose(after_->time);
  after_ = {time, pose};
  between_.add(time, pose.isometry());
  if (waiting_.empty() && emitted_ > 0 && time == emitted_time_) between_.to(time, pose.isometry());
  // Further observations with the time of this odometry may follow; those before the first wait for
  // the second, which tells how far apart they are.
  if (before_) release_until(std::nextafter(after_->time, 0.0));
}

/// Ends the odometry so far: what comes is in another frame.
void RawlogReader::start_odometry_anew() {
  before_.reset();
  release_until(std::numeric_limits<double>::infinity());
  after_.reset();
  last_pose_.reset();
  between_.lose(std::numeric_limits<double>::infinity());
  gap_.start_anew();
}

void RawlogReader::release_until(double time) {
  while (!waiting_.empty() && waiting_.front().time <= time) release_front();
}

void RawlogReader::release_front() {
  LogStep step = std::move(waiting_.front());
  waiting_.pop_front();
  if (after_ && before_ && !is_within_reach(*before_, *after_)) {
    ++warnings_[kTooFar];  // one of the two is wrong, but it is unknown which
    last_pose_.reset();
  } else if (after_ && (is_beyond_odometry(step.time) || is_in_gap(step.time))) {
    last_pose_.reset();
  } else if (after_ && before_ && after_->time > before_->time) {
    const double fraction = (step.time - before_->time) / (after_->time - before_->time);
    move_to(step, between(before_->pose, after_->pose, std::clamp(fraction, 0.0, 1.0)));
  } else if (after_) {
    move_to(step, after_->pose);
  }
  if (!last_pose_) between_.lose(step.time);
  emit(std::move(step));
}

void RawlogReader::move_to(LogStep& step, const OdometryReading& pose) {
  if (last_pose_) {
    const MotionModel& model = options_.motion_model;
    step.odometry =
        checked(pose.space ? odometry_between(last_pose_->in_space(), *pose.space, model)
                           : odometry_between(last_pose_->plane, pose.plane, model));
  }
  if (!step.odometry) between_.lose(step.time);
  step.between = between_.to(step.time, pose.isometry());
  last_pose_ = pose;
}

void RawlogReader::emit(LogStep step) {
  drop_implausible(step);
  emitted_time_ = step.time;
  step.index = emitted_++;
  ready_.push_back(std::move(step));
}

/// How far the robot can move in a time. Time stamps may repeat or be those of a simulation, so
/// that at least one period counts.
double RawlogReader::reach(double time) const {
  return options_.max_speed * std::max(time, options_.period);
}

bool RawlogReader::is_within_reach(const TimedOdometry& before, const TimedOdometry& after) const {
  return (after.pose.position() - before.pose.position()).norm() <= reach(after.time - before.time);
}

/// Whether a time is so long before the first odometry, or after the last, that its pose is not
/// that of the nearest: longer than from one odometry to the next, twice.
bool RawlogReader::is_beyond_odometry(double time) const {
  const double first = before_ ? before_->time : after_->time;
  const double most = before_ ? 2 * (after_->time - first) : options_.period;
  return std::max(first - time, time - after_->time) > most;
}

/// Whether a time is where poses are missing while the robot moved.
bool RawlogReader::is_in_gap(double time) const {
  return has_gap_ && before_ && before_->time < time && time < after_->time;
}

void RawlogReader::drop_implausible(LogStep& step) {
  const double time = emitted_ > 0 ? step.time - emitted_time_ : 0.0;
  if (!step.odometry || is_plausible(*step.odometry, reach(time))) return;
  ++warnings_[kTooFar];
  step.odometry.reset();
  step.between.clear();
}

double RawlogReader::repeated_stamps() const {
  return moves_at_once_ ? static_cast<double>(repeated_) / static_cast<double>(readings_) : 0.0;
}

DropReport RawlogReader::warnings() const {
  DropReport all = warnings_;
  for (const std::string& note : objects_.notes()) ++all[note];
  if (repeated_stamps() > kCoarseClock) {
    ++all[fmt::format(
        "{} of {} stamps of the odometry are that of the one before, although the "
        "robot moves: the clock is too coarse, and the result doubtful",
        repeated_, readings_)];
  }
  if (!has_odometry_ && !acts_ && observations_.count("CObservationRobotPose") != 0) {
    ++all["the log has no odometry but poses of the robot: they are taken for it"];
  }
  return all;
}

double RawlogReader::time_of(mrpt::system::TTimeStamp stamp) {
  double time = last_time_ + options_.period;
  if (stamp == INVALID_TIMESTAMP) {
    ++warnings_["timestamp missing: synthesised"];
  } else {
    time = seconds_of(stamp) + options_.clock_offset;
  }
  return time;
}

double RawlogReader::advance_to(double time) {
  if (started_ && time < last_time_) {
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
