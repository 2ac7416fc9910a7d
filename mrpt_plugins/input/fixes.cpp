// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/fixes.h"

#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/obs/gnss_messages_ascii_nmea.h>
#include <mrpt/obs/gnss_messages_novatel.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "libhybrid/geometry/se3.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/mrpt_version.h"

namespace hybrid {
namespace {

using mrpt::obs::CObservationGPS;
using mrpt::obs::gnss::Message_NMEA_GGA;
using mrpt::obs::gnss::Message_NMEA_RMC;
using mrpt::obs::gnss::Message_NV_OEM6_BESTPOS;

constexpr double kMostAntenna = 1000;  // m
constexpr double kMostSigma = 1e4;     // m
constexpr double kNear = 1000;         // m, between two fixes that confirm each other
constexpr double kFastest = 100;       // m/s, added to that
constexpr double kMostDistant = 1e6;   // m, of a fix from the datum

/// A message of an observation; null where it has none of this class. (MRPT's own function of that
/// kind does not compile for observations that are const.)
template <class Message>
const Message* message_in(const CObservationGPS& seen) {
  return seen.hasMsgClass<Message>() ? &seen.getMsgByClass<Message>() : nullptr;
}

/// What each horizontal axis of a fix is off by [m], by the quality that a GGA message states.
std::optional<double> sigma_of_quality(int quality) {
  switch (quality) {
    case 0:
      return std::nullopt;
    case 2:  // differential
    case 3:  // PPS
      return 1;
    case 4:  // ambiguities fixed
      return 0.02;
    case 5:  // ambiguities not fixed
      return 0.3;
    default:
      return 2;
  }
}

/// Position and sigma; nothing where the receiver says that it has none.
std::optional<LoggedFix> position_in(const CObservationGPS& seen) {
  LoggedFix out;
  if (const auto* gga = message_in<Message_NMEA_GGA>(seen)) {
    const auto& f = gga->fields;
    const auto sigma = sigma_of_quality(f.fix_quality);
    if (!sigma) return std::nullopt;
    out.place = {f.latitude_degrees, f.longitude_degrees, f.altitude_meters};
    const bool diluted = f.thereis_HDOP && f.HDOP >= 0.5F && f.HDOP <= 50.0F;
    out.fix.sigma = *sigma * (diluted ? static_cast<double>(f.HDOP) : 1.0);
  } else if (const auto* rmc = message_in<Message_NMEA_RMC>(seen)) {
    if (rmc->fields.validity_char != 'A') return std::nullopt;
    out.place = {rmc->fields.latitude_degrees, rmc->fields.longitude_degrees, 0};
    out.fix.sigma = 2;
  } else if (!message_in<Message_NV_OEM6_BESTPOS>(seen)) {
    return std::nullopt;
  }
  if (const auto* best = message_in<Message_NV_OEM6_BESTPOS>(seen)) {
    const auto& f = best->fields;
    if (out.fix.sigma == 0) out.place = {f.lat, f.lon, f.hgt};
    const double sigma =
        std::max(static_cast<double>(f.lat_sigma), static_cast<double>(f.lon_sigma));
    out.fix.sigma = sigma > 0 && sigma < kMostSigma ? sigma : std::max(out.fix.sigma, 2.0);
  }
  return out;
}

/// A share of a motion, at constant velocity.
Eigen::Isometry3d part(const Eigen::Isometry3d& T, double share) {
  return to_isometry(SE3::exp(share * to_se3(T).log()));
}

}  // namespace

std::optional<LoggedFix> fix_in(const mrpt::obs::CObservation& observation, DropReport& report) {
  const auto* seen = dynamic_cast<const CObservationGPS*>(&observation);
  if (seen == nullptr) return std::nullopt;
  std::optional<LoggedFix> out = position_in(*seen);
  if (!out) {
    ++report["fix dropped: the receiver says that it has none"];
    return std::nullopt;
  }
  const GeodeticPoint& p = out->place;
  out->fix.antenna = point_of(seen->sensorPose);
  out->fix.sensor = seen->sensorLabel;
  if (!std::isfinite(p.longitude) || !std::isfinite(p.altitude) || !(std::abs(p.latitude) <= 90) ||
      std::abs(p.altitude) > 1e7) {
    ++report["fix dropped: not a place on earth"];
    return std::nullopt;
  }
  const std::string& label = out->fix.sensor;
  const std::string local = "_local";
  out->is_on_earth = label.size() < local.size() ||
                     label.compare(label.size() - local.size(), local.size(), local) != 0;
  if (out->is_on_earth && p.latitude == 0 && p.longitude == 0) {
    ++report["fix dropped: at latitude and longitude 0"];
    return std::nullopt;
  }
  if (!(out->fix.antenna.norm() <= kMostAntenna)) {
    ++report["fix dropped: its antenna is not on the robot"];
    return std::nullopt;
  }
  if (seen->timestamp != INVALID_TIMESTAMP) out->fix.time = seconds_of(seen->timestamp);
  return out;
}

bool RepeatedFixes::is_repeated(const LoggedFix& fix) {
  const GeodeticPoint& place = fix.place;
  const auto [found, is_first] = last_.emplace(fix.fix.sensor, place);
  if (is_first) return false;
  const GeodeticPoint last = std::exchange(found->second, place);
  return last.latitude == place.latitude && last.longitude == place.longitude &&
         last.altitude == place.altitude;
}

bool DatumFinder::confirms(const LoggedFix& fix) {
  if (frame_) return true;
  const std::optional<LoggedFix> before = std::exchange(first_, fix);
  if (!before) return false;
  const double apart = (ecef_of(fix.place) - ecef_of(before->place)).norm();
  if (apart > kNear + kFastest * std::max(0.0, fix.fix.time - before->fix.time)) return false;
  frame_.emplace(before->place);
  is_on_earth_ = before->is_on_earth;
  return true;
}

std::optional<Eigen::Vector3d> DatumFinder::to_local(const LoggedFix& fix, DropReport& report) {
  if (!confirms(fix)) {
    ++report["fix dropped: before two that confirm each other"];
    return std::nullopt;
  }
  const Eigen::Vector3d local = frame_->to_local(fix.place);
  if (local.norm() <= kMostDistant) {
    ++near_;
    return local;
  }
  ++far_;
  ++report["fix dropped: farther than 1,000 km from the datum"];
  return std::nullopt;
}

void FixCollector::move(double time, const std::optional<OdometryIncrement>& odometry,
                        DropReport& report) {
  time_before_ = std::exchange(time_, time);
  if (odometry) {
    T_before_now_ = to_isometry(odometry->mean);
    T_keyframe_robot_ = T_keyframe_robot_ * T_before_now_;
    return;
  }
  if (!fixes_.empty()) report["fix dropped: no odometry from there to a keyframe"] += fixes_.size();
  fixes_.clear();
  T_keyframe_robot_.setIdentity();
  T_before_now_.setIdentity();
}

void FixCollector::add(LoggedFix fix, DropReport& report) {
  fix.fix.row = rows_++;
  if (repeats_.is_repeated(fix)) {
    ++report["fix dropped: the receiver repeats the last one"];
    return;
  }
  fix.fix.T_keyframe_robot = T_keyframe_robot_;
  if (fix.fix.time == 0) fix.fix.time = time_;
  const double period = time_ - time_before_, early = time_ - fix.fix.time + fix.fix.delay;
  if (period > 0 && std::abs(early) <= std::max(2 * period, std::abs(fix.fix.delay))) {
    fix.fix.T_keyframe_robot = T_keyframe_robot_ * part(T_before_now_, -early / period);
  }
  fixes_.push_back(std::move(fix));
}

std::vector<LoggedFix> FixCollector::release() {
  const Eigen::Isometry3d T_now_before = T_keyframe_robot_.inverse();
  for (LoggedFix& fix : fixes_) fix.fix.T_keyframe_robot = T_now_before * fix.fix.T_keyframe_robot;
  T_keyframe_robot_.setIdentity();
  return std::exchange(fixes_, {});
}

}  // namespace hybrid
