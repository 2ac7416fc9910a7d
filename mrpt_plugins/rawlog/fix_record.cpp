// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/detail/fix_record.h"

#include "mrpt_plugins/bridge/enu_covariance.h"

namespace hybrid {
namespace {

using mrpt::obs::CObservationGPS;
using mrpt::obs::gnss::gnss_message_type_t;
using mrpt::obs::gnss::UTC_time;
using Gga = mrpt::obs::gnss::Message_NMEA_GGA;
using Rmc = mrpt::obs::gnss::Message_NMEA_RMC;
using BestPos = mrpt::obs::gnss::Message_NV_OEM6_BESTPOS;

// The fields of messages are packed: they are copied, since no reference can be bound to them.

void write_utc(ByteWriter& out, const UTC_time& t) {
  put_all(out, t.hour, t.minute, t.sec);
}

UTC_time read_utc(ByteReader& in) {
  UTC_time t;
  t.hour = in.get<std::uint8_t>();
  t.minute = in.get<std::uint8_t>();
  t.sec = in.get<double>();
  return t;
}

void write_fields(ByteWriter& out, const Gga::content_t& f) {
  write_utc(out, f.UTCTime);
  put_all(out, f.latitude_degrees, f.longitude_degrees, f.fix_quality, f.altitude_meters,
          f.geoidal_distance, f.orthometric_altitude, f.corrected_orthometric_altitude,
          f.satellitesUsed);
  out.put_flag(f.thereis_HDOP);
  out.put(f.HDOP);
}

void read_fields(ByteReader& in, Gga::content_t& f) {
  f.UTCTime = read_utc(in);
  f.latitude_degrees = in.get<double>();
  f.longitude_degrees = in.get<double>();
  f.fix_quality = in.get<std::uint8_t>();
  f.altitude_meters = in.get<double>();
  f.geoidal_distance = in.get<double>();
  f.orthometric_altitude = in.get<double>();
  f.corrected_orthometric_altitude = in.get<double>();
  f.satellitesUsed = in.get<std::uint32_t>();
  f.thereis_HDOP = in.flag();
  f.HDOP = in.get<float>();
}

void write_fields(ByteWriter& out, const Rmc::content_t& f) {
  write_utc(out, f.UTCTime);
  put_all(out, f.validity_char, f.latitude_degrees, f.longitude_degrees, f.speed_knots,
          f.direction_degrees, f.date_day, f.date_month, f.date_year, f.magnetic_dir,
          f.positioning_mode);
}

void read_fields(ByteReader& in, Rmc::content_t& f) {
  f.UTCTime = read_utc(in);
  f.validity_char = in.get<std::int8_t>();
  f.latitude_degrees = in.get<double>();
  f.longitude_degrees = in.get<double>();
  f.speed_knots = in.get<double>();
  f.direction_degrees = in.get<double>();
  f.date_day = in.get<std::uint8_t>();
  f.date_month = in.get<std::uint8_t>();
  f.date_year = in.get<std::uint8_t>();
  f.magnetic_dir = in.get<double>();
  f.positioning_mode = in.get<char>();
}

void write_fields(ByteWriter& out, const BestPos::content_t& f) {
  put_all(out, static_cast<std::uint32_t>(f.solution_stat),
          static_cast<std::uint32_t>(f.position_type), f.lat, f.lon, f.hgt, f.undulation,
          f.lat_sigma, f.lon_sigma, f.hgt_sigma);
}

void read_fields(ByteReader& in, BestPos::content_t& f) {
  f.solution_stat = static_cast<decltype(f.solution_stat)>(in.get<std::uint32_t>());
  f.position_type = static_cast<decltype(f.position_type)>(in.get<std::uint32_t>());
  f.lat = in.get<double>();
  f.lon = in.get<double>();
  f.hgt = in.get<double>();
  f.undulation = in.get<float>();
  f.lat_sigma = in.get<float>();
  f.lon_sigma = in.get<float>();
  f.hgt_sigma = in.get<float>();
}

template <class Message>
void write_message(ByteWriter& out, const CObservationGPS& fix) {
  const auto it = fix.messages.find(static_cast<gnss_message_type_t>(Message::msg_type));
  const auto* message =
      it == fix.messages.end() ? nullptr : dynamic_cast<const Message*>(it->second.get());
  out.put_flag(message != nullptr);
  if (message != nullptr) write_fields(out, message->fields);
}

template <class Message>
void read_message(ByteReader& in, CObservationGPS& fix) {
  if (!in.flag()) return;
  Message message;
  read_fields(in, message.fields);
  fix.setMsg(message);
}

}  // namespace

void write_fix(ByteWriter& out, const CObservationGPS& fix) {
  write_time(out, fix.originalReceivedTimestamp);
  out.put_flag(fix.has_satellite_timestamp);
  write_pose(out, fix.sensorPose);
  const EnuCovariance covariance = enu_covariance(fix);
  out.put_flag(covariance.has_value());
  if (covariance) write_matrix(out, *covariance);
  write_message<Gga>(out, fix);
  write_message<Rmc>(out, fix);
  write_message<BestPos>(out, fix);
}

void read_fix(ByteReader& in, CObservationGPS& fix) {
  fix.originalReceivedTimestamp = read_time(in);
  fix.has_satellite_timestamp = in.flag();
  fix.sensorPose = read_pose_3d(in);
  if (in.flag()) {
    mrpt::math::CMatrixDouble33 covariance;
    read_matrix(in, covariance);
    set_enu_covariance(fix, covariance);
  }
  read_message<Gga>(in, fix);
  read_message<Rmc>(in, fix);
  read_message<BestPos>(in, fix);
}

}  // namespace hybrid
