// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/bridge/satellite_fix.h"

#include <mrpt/core/Clock.h>

#include <cmath>

namespace hybrid {
namespace {

using mrpt::obs::gnss::UTC_time;
using GgaMessage = mrpt::obs::gnss::Message_NMEA_GGA;
using BestPosMessage = mrpt::obs::gnss::Message_NV_OEM6_BESTPOS;
namespace position_type = mrpt::obs::gnss::nv_oem6_position_type;
namespace solution_status = mrpt::obs::gnss::nv_oem6_solution_status;

/// The time of day.
UTC_time utc_of(double time) {
  constexpr double kMinute = 60, kHour = 3600, kDay = 86400;
  const double second = time - kDay * std::floor(time / kDay);
  const auto hour = static_cast<int>(second / kHour);
  const auto minute = static_cast<int>((second - kHour * hour) / kMinute);
  UTC_time utc;
  utc.hour = static_cast<std::uint8_t>(hour);
  utc.minute = static_cast<std::uint8_t>(minute);
  utc.sec = second - kHour * hour - kMinute * minute;
  return utc;
}

/// What Novatel calls a quality of GGA.
position_type::nv_position_type_t type_of(std::uint8_t quality) {
  switch (quality) {
    case 1:
    case 3:
      return position_type::SINGLE;
    case 2:
      return position_type::PSRDIFF;
    case 4:
      return position_type::NARROW_INT;
    case 5:
      return position_type::NARROW_FLOAT;
    case 6:
      return position_type::PROPAGATED;
    case 7:
      return position_type::FIXEDPOS;
    default:
      return position_type::NONE;
  }
}

BestPosMessage best_pos(const SatelliteFix& fix) {
  BestPosMessage message;
  auto& fields = message.fields;
  fields.solution_stat =
      fix.quality == 0 ? solution_status::INSUFFICIENT_OBS : solution_status::SOL_COMPUTED;
  fields.position_type = type_of(fix.quality);
  fields.lat = fix.place.latitude;
  fields.lon = fix.place.longitude;
  fields.hgt = fix.place.altitude;
  fields.lat_sigma = static_cast<float>(fix.sigma);
  fields.lon_sigma = static_cast<float>(fix.sigma);
  return message;
}

}  // namespace

mrpt::obs::CObservationGPS::Ptr satellite_fix(const SatelliteFix& fix, const std::string& label,
                                              const mrpt::poses::CPose3D& T_robot_antenna) {
  auto observation = mrpt::obs::CObservationGPS::Create();
  observation->sensorLabel = label;
  observation->timestamp = mrpt::Clock::fromDouble(fix.time);
  observation->originalReceivedTimestamp = observation->timestamp;
  observation->sensorPose = T_robot_antenna;
  GgaMessage message;
  message.fields.UTCTime = utc_of(fix.time);
  message.fields.latitude_degrees = fix.place.latitude;
  message.fields.longitude_degrees = fix.place.longitude;
  message.fields.altitude_meters = fix.place.altitude;
  message.fields.geoidal_distance = 0;
  message.fields.orthometric_altitude = fix.place.altitude;
  message.fields.corrected_orthometric_altitude = fix.place.altitude;
  message.fields.fix_quality = fix.quality;
  observation->setMsg(message);
  if (fix.sigma > 0) observation->setMsg(best_pos(fix));
  return observation;
}

}  // namespace hybrid
