// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/log_record.h"

#include <gtest/gtest.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationBeaconRanges.h>
#include <mrpt/obs/CObservationGPS.h>
#include <mrpt/obs/CObservationRange.h>

#include <cmath>
#include <random>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/observations/classed_bearing_range.h"
#include "mrpt_plugins/rawlog/observation_record.h"
#include "tests/mrpt_plugins/input/log_files.h"

namespace hybrid {
namespace {

using mrpt::obs::CObservation;
using mrpt::obs::CObservation2DRangeScan;
using mrpt::obs::CObservationBeaconRanges;
using mrpt::obs::CObservationBearingRange;

constexpr std::uint64_t kMost = 1U << 24;

AskedClasses nothing() {
  register_mrpt_classes();
  return AskedClasses({});
}

LoggedObservation logged(const CObservation::Ptr& content) {
  return {content->GetRuntimeClass()->className, content->timestamp, content, {}};
}

/// Written and read again.
template <class T>
T round_trip(const T& object, const AskedClasses& asked = nothing()) {
  RecordReader reader(asked, kMost);
  reader.add(to_bytes(LogObject(object), asked));
  const auto record = reader.next();
  EXPECT_FALSE(reader.next());
  return std::get<T>(std::get<LogObject>(*record));
}

/// The bytes that MRPT makes of an observation: equal ones mean equal content.
std::string serialised(const CObservation::Ptr& observation) {
  const TemporaryFile file("serialised");
  write_log(file.path(), {observation});
  return read_bytes(file.path());
}

mrpt::poses::CPose3D odd_pose() {
  return {0.1, -0.2, 0.3, 0.4, -0.5, 0.6};
}

CObservation::Ptr bearing_range(bool own_covariances) {
  auto o = CObservationBearingRange::Create();
  o->sensorLabel = "a sensor";
  o->timestamp = mrpt::Clock::fromDouble(1.1e9);
  o->minSensorDistance = 0.5F;
  o->maxSensorDistance = 20;
  o->fieldOfView_yaw = 3;
  o->fieldOfView_pitch = 0.25F;
  o->sensorLocationOnRobot = odd_pose();
  o->validCovariances = own_covariances;
  if (!own_covariances) o->sensor_std_range = 0.1F;
  for (int i = 0; i < 5; ++i) {
    o->sensedData.push_back({1.1F * i, 0.1F * i, -0.2F, i - 1, {}});
    o->sensedData.back().covariance.setDiagonal(3, 0.1 * i);
  }
  return o;
}

CObservation::Ptr classed() {
  auto o = std::make_shared<CObservationClassedBearingRange>();
  o->sensorLabel = "detector";
  o->timestamp = mrpt::Clock::fromDouble(7);
  o->sensor_pose = odd_pose();
  o->min_range = 1;
  o->max_range = 30;
  o->fov_yaw = 2;
  o->fov_pitch = 1;
  o->std_range = 0.1F;
  o->std_yaw = 0.01F;
  o->std_pitch = 0.02F;
  o->has_range = false;
  o->has_pitch = false;
  o->class_names = {"tree", "", "car"};
  o->detections = {{3, 0.5F, -0.25F, 4, 5, {0.25F, 0.75F, 0}, 0.1F, 0.2F, 0.3F}, {}};
  return o;
}

CObservation::Ptr beacons() {
  auto o = CObservationBeaconRanges::Create();
  o->stdError = 0.2F;
  o->maxSensorDistance = 7;
  o->auxEstimatePose = {1, 2, 0.1};
  for (int i = 0; i < 3; ++i) {
    CObservationBeaconRanges::TMeasurement m;
    m.sensorLocationOnRobot = {0.1 * i, 2, 3};
    m.sensedDistance = 4.5F + static_cast<float>(i);
    m.beaconID = i;
    o->sensedData.push_back(m);
  }
  return o;
}

CObservation2DRangeScan::Ptr scan() {
  auto o = CObservation2DRangeScan::Create();
  o->timestamp = mrpt::Clock::fromDouble(5);
  o->sensorLabel = "laser";
  o->aperture = 4.5F;
  o->maxRange = 30;
  o->rightToLeft = false;
  o->sensorPose = odd_pose();
  o->stdError = 0.02F;
  o->beamAperture = 0.001F;
  o->deltaPitch = 0.25;
  o->resizeScanAndAssign(10, 3.0F, true);
  o->setScanRange(3, 1.25F);
  o->setScanRangeValidity(7, false);
  return o;
}

/// A satellite fix with messages GGA, RMC and BESTPOS, no two numbers of which are the same.
mrpt::obs::CObservationGPS::Ptr fix() {
  using namespace mrpt::obs::gnss;
  auto o = mrpt::obs::CObservationGPS::Create();
  o->timestamp = mrpt::Clock::fromDouble(1.2e9);
  o->originalReceivedTimestamp = mrpt::Clock::fromDouble(1.2e9 + 0.25);
  o->has_satellite_timestamp = true;
  o->sensorLabel = "receiver";
  o->sensorPose = odd_pose();
  Message_NMEA_GGA gga;
  gga.fields.UTCTime.hour = 23;
  gga.fields.UTCTime.minute = 59;
  gga.fields.UTCTime.sec = 58.5;
  gga.fields.latitude_degrees = -33.885;
  gga.fields.longitude_degrees = 151.19;
  gga.fields.fix_quality = 4;
  gga.fields.altitude_meters = 61;
  gga.fields.geoidal_distance = 22.5;
  gga.fields.orthometric_altitude = 83.5;
  gga.fields.corrected_orthometric_altitude = std::nan("");
  gga.fields.satellitesUsed = 11;
  gga.fields.thereis_HDOP = true;
  gga.fields.HDOP = 0.75F;
  o->setMsg(gga);
  Message_NMEA_RMC rmc;
  rmc.fields.UTCTime.hour = 1;
  rmc.fields.UTCTime.minute = 2;
  rmc.fields.UTCTime.sec = 3.25;
  rmc.fields.validity_char = 'A';
  rmc.fields.latitude_degrees = 36.5;
  rmc.fields.longitude_degrees = -4.25;
  rmc.fields.speed_knots = 5.5;
  rmc.fields.direction_degrees = 271;
  rmc.fields.date_day = 31;
  rmc.fields.date_month = 12;
  rmc.fields.date_year = 99;
  rmc.fields.magnetic_dir = -1.5;
  rmc.fields.positioning_mode = 'D';
  o->setMsg(rmc);
  Message_NV_OEM6_BESTPOS best;
  best.fields.header = {};
  best.fields.solution_stat = nv_oem6_solution_status::SOL_COMPUTED;
  best.fields.position_type = nv_oem6_position_type::NARROW_INT;
  best.fields.lat = 48.5;
  best.fields.lon = 9.125;
  best.fields.hgt = 301;
  best.fields.undulation = 47.75F;
  best.fields.lat_sigma = 0.01F;
  best.fields.lon_sigma = 0.02F;
  best.fields.hgt_sigma = 0.03F;
  o->setMsg(best);
  return o;
}

TEST(LogRecord, ObservationsThatWeKnowKeepEveryNumber) {
  for (const auto& o :
       {bearing_range(false), bearing_range(true), classed(), beacons(),
        absolute_odometry(3, {1, 2, 0.3}), CObservation::Ptr(scan()), CObservation::Ptr(fix())}) {
    const LoggedObservation out = round_trip(logged(o));
    ASSERT_TRUE(out.content) << o->GetRuntimeClass()->className;
    EXPECT_EQ(out.time, o->timestamp);
    EXPECT_EQ(out.class_name, o->GetRuntimeClass()->className);
    EXPECT_TRUE(serialised(out.content) == serialised(o)) << out.class_name;
  }
}

TEST(LogRecord, OtherObservationsComeOnlyWhereAskedFor) {
  auto sonar = mrpt::obs::CObservationRange::Create();
  sonar->timestamp = mrpt::Clock::fromDouble(5);
  sonar->sensorLabel = "sonar";
  LoggedObservation observation = logged(sonar);
  observation.points = {{1, 2, 3}, {4, 5, 6}};
  const LoggedObservation absent = round_trip(observation);
  EXPECT_FALSE(absent.content);
  EXPECT_EQ(absent.time, sonar->timestamp);
  ASSERT_EQ(absent.points.size(), 2U);
  EXPECT_EQ(absent.points[1].z, 6);
  for (const std::string name : {"CObservationRange", "mrpt::obs::CObservationRange"}) {
    const LoggedObservation present =
        round_trip(observation, AskedClasses({"CObservation2DRangeScan", name}));
    ASSERT_TRUE(present.content);
    EXPECT_TRUE(serialised(present.content) == serialised(sonar));
  }
  EXPECT_THROW(AskedClasses({"CObservationNobodyKnows"}), Error);
  EXPECT_THROW(AskedClasses({"CSensoryFrame"}), Error);
  EXPECT_THROW(AskedClasses({"mrpt::obs::CObservation"}), Error) << "abstract";
}

TEST(LogRecord, OfAScanIntensitiesComeOnlyWhereAskedFor) {
  const auto bright = scan();
  bright->setScanHasIntensity(true);
  bright->setScanIntensity(2, 77);
  const auto known =
      std::dynamic_pointer_cast<CObservation2DRangeScan>(round_trip(logged(bright)).content);
  ASSERT_TRUE(known);
  EXPECT_FALSE(known->hasIntensity());
  EXPECT_EQ(known->getScanRange(3), 1.25F);
  const auto asked = round_trip(logged(bright), AskedClasses({"CObservation2DRangeScan"}));
  EXPECT_TRUE(serialised(asked.content) == serialised(bright));
}

TEST(LogRecord, OfAFixOtherMessagesAreLeftOut) {
  const auto whole = fix();
  mrpt::obs::gnss::Message_NMEA_GLL other;
  whole->setMsg(other);
  const auto known =
      std::dynamic_pointer_cast<mrpt::obs::CObservationGPS>(round_trip(logged(whole)).content);
  ASSERT_TRUE(known);
  EXPECT_EQ(known->messages.size(), 3U);
  const auto without = mrpt::obs::CObservationGPS::Create();
  EXPECT_TRUE(serialised(round_trip(logged(without)).content) == serialised(without));
  const auto asked = round_trip(logged(whole), AskedClasses({"CObservationGPS"}));
  EXPECT_TRUE(serialised(asked.content) == serialised(whole));
}

TEST(LogRecord, ADamagedFixIsRefused) {
  const std::string bytes = to_bytes(LogObject(logged(fix())), nothing());
  constexpr std::size_t kHead = 9;  // the size of the record and its kind
  const auto read = [](std::string content, char kind) {
    ByteWriter head;
    head.put(static_cast<std::uint64_t>(content.size()));
    head.put(kind);
    RecordReader reader(nothing(), kMost);
    reader.add(head.bytes() + content);
    return reader.next().has_value();
  };
  const std::string content = bytes.substr(kHead);
  EXPECT_TRUE(read(content, bytes[8]));
  for (std::size_t length = 0; length < content.size(); ++length) {
    EXPECT_THROW(read(content.substr(0, length), bytes[8]), Error) << length;
  }
  EXPECT_THROW(read(content + "x", bytes[8]), Error);
}

TEST(LogRecord, AnAskedClassIsNeverTakenForAnother) {
  // A record that claims to be a scan and holds an object of another class.
  auto gps = mrpt::obs::CObservationGPS::Create();
  LoggedObservation lie = logged(gps);
  const AskedClasses both({"CObservationGPS", "CObservation2DRangeScan"});
  std::string bytes = to_bytes(LogObject(lie), both);
  const std::string from = lie.class_name, to = "mrpt::obs::CObservation2DRangeScan";
  ByteWriter sizes;
  sizes.put(static_cast<std::uint64_t>(bytes.size() - 9 + to.size() - from.size()));
  bytes.replace(bytes.find(from), from.size(), to);
  bytes.replace(0, 8, sizes.bytes());
  bytes[9] = static_cast<char>(to.size());
  RecordReader reader(both, kMost);
  reader.add(bytes);
  EXPECT_THROW(reader.next(), std::exception);
}

TEST(LogRecord, MotionsKeepEveryBit) {
  LoggedActions actions;
  actions.time = mrpt::Clock::fromDouble(9);
  EXPECT_EQ(round_trip(actions).motion.index(), 0U);
  mrpt::poses::CPosePDFGaussian plane({1.1, -2.2, 0.1});
  plane.cov(0, 1) = 0.3;
  actions.motion = plane;
  const auto flat = std::get<1>(round_trip(actions).motion);
  EXPECT_EQ(flat.mean.phi(), plane.mean.phi());
  EXPECT_EQ(flat.mean.x(), 1.1);
  EXPECT_EQ(flat.cov(0, 1), 0.3);
  mrpt::poses::CPose3DPDFGaussian space(odd_pose());
  space.cov(5, 2) = -0.7;
  actions.motion = space;
  const LoggedActions out = round_trip(actions);
  EXPECT_EQ(out.time, actions.time);
  const auto& solid = std::get<2>(out.motion);
  EXPECT_TRUE(solid.mean.getRotationMatrix() == space.mean.getRotationMatrix());
  EXPECT_EQ(solid.mean.z(), space.mean.z());
  EXPECT_EQ(solid.cov(5, 2), -0.7);
}

TEST(LogRecord, TheRestComesBackToo) {
  const LoggedFrame frame{{logged(beacons()), logged(classed())}};
  EXPECT_EQ(round_trip(frame).observations.size(), 2U);
  EXPECT_EQ(round_trip(LoggedPoints{{{1, 2, 3}}}).points[0].y, 2);
  EXPECT_EQ(round_trip(OtherObject{"CThing"}).class_name, "CThing");
  RecordReader reader(nothing(), kMost);
  const std::string bytes = to_bytes(ParserStarted{true}, nothing()) +
                            to_bytes(ParsingClass{"CThing"}, nothing()) +
                            to_bytes(LogEnd{LogStatus::kTruncated, "it ends", true}, nothing());
  std::vector<LogRecord> records;
  for (const char byte : bytes) {
    reader.add({&byte, 1});
    while (auto record = reader.next()) records.push_back(*record);
  }
  ASSERT_EQ(records.size(), 3U);
  EXPECT_TRUE(std::get<ParserStarted>(records[0]).is_confined);
  EXPECT_EQ(std::get<ParsingClass>(records[1]).name, "CThing");
  const auto end = std::get<LogEnd>(records[2]);
  EXPECT_EQ(end.status, LogStatus::kTruncated);
  EXPECT_EQ(end.reason, "it ends");
  EXPECT_TRUE(end.has_trailing_bytes);
}

TEST(LogRecord, TooManyDetectionsAreRefused) {
  auto o = CObservationBearingRange::Create();
  o->sensedData.resize(kMaxDetections + 1);
  EXPECT_THROW(to_bytes(LogObject(logged(o)), nothing()), Error);
  o->sensedData.resize(kMaxDetections);
  EXPECT_EQ(round_trip(logged(o)).points.size(), 0U);
  const auto wide = scan();
  wide->resizeScanAndAssign(kMaxDetections + 1, 1.0F, true);
  EXPECT_THROW(to_bytes(LogObject(logged(wide)), nothing()), Error);
}

/// Whatever a process that was taken over may send: only Error comes of it.
TEST(LogRecord, AnyBytesAreReadOrRefused) {
  const AskedClasses asked = nothing();
  std::string stream;
  for (const auto& o : {bearing_range(false), bearing_range(true), classed(), beacons(),
                        CObservation::Ptr(scan()), CObservation::Ptr(fix())}) {
    stream += to_bytes(LogObject(logged(o)), asked);
    stream += to_bytes(LogObject(LoggedFrame{{logged(o), logged(o)}}), asked);
  }
  LoggedActions actions;
  actions.motion = mrpt::poses::CPose3DPDFGaussian(odd_pose());
  stream += to_bytes(LogObject(actions), asked);
  stream += to_bytes(LogObject(LoggedPoints{{{1, 2, 3}}}), asked);
  std::mt19937 random(11);
  int refused = 0, read = 0;
  for (int trial = 0; trial < 20'000; ++trial) {
    std::string bytes = stream;
    for (int i = 0; i < 1 + trial % 4; ++i) {
      const std::size_t at = random() % bytes.size();
      if (trial % 3 == 0) {
        bytes.erase(at, random() % 8);
      } else {
        bytes[at] = static_cast<char>(trial % 3 == 1 ? random() : 0xff);
      }
    }
    RecordReader reader(asked, kMost);
    reader.add(bytes);
    try {
      while (reader.next()) ++read;
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 5000);
  EXPECT_GT(read, 20'000);
}

TEST(LogRecord, AHugeRecordIsRefusedBeforeItComes) {
  RecordReader reader(nothing(), 1000);
  ByteWriter head;
  head.put<std::uint64_t>(1001);
  head.put<std::uint8_t>(0);
  reader.add(head.bytes());
  EXPECT_THROW(reader.next(), Error);
}

}  // namespace
}  // namespace hybrid
