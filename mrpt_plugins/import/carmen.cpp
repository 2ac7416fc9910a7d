// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/carmen.h"

#include <bzlib.h>
#include <fmt/format.h>
#include <mrpt/core/bits_math.h>
#include <mrpt/obs/CObservation2DRangeScan.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <new>
#include <optional>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/io/regular_file.h"
#include "libhybrid/io/text_reader.h"
#include "mrpt_plugins/rawlog/byte_io.h"
#include "mrpt_plugins/rawlog/decoder.h"

namespace hybrid {
namespace {

using mrpt::obs::CObservation2DRangeScan;
using mrpt::poses::CPose2D;
using mrpt::poses::CPose3D;

constexpr double kHalfTurn = 180;                        // deg
constexpr double kUsualMaxRange = 80;                    // m, of the SICK scanners of these logs
constexpr std::size_t kMostText = std::size_t{1} << 30;  // bytes of a compressed log in memory
constexpr std::string_view kBzip2Magic = "BZh";
const TextFormat kCarmenFormat{TextFormat::Cut::kWords, ""};

/// A compressed file as text; `step` appends some of it and returns whether there is more.
template <class Step>
std::string unpacked(const std::string& path, Step step) {
  std::string text;
  while (step(text)) {
    if (text.size() > kMostText) {
      throw Error(path + ": more than 1 GiB when decompressed: decompress it first");
    }
  }
  return text;
}

/// The streams of a bzip2 file, one after the other; pbzip2 makes several.
class Bzip2Streams {
 public:
  Bzip2Streams(const std::string& path, const std::string& bytes) : path_(path), rest_(bytes) {
    begin();
  }
  ~Bzip2Streams() { BZ2_bzDecompressEnd(&stream_); }
  Bzip2Streams(const Bzip2Streams&) = delete;
  Bzip2Streams& operator=(const Bzip2Streams&) = delete;

  /// Appends some of the text; returns whether there is more.
  bool step(std::string& text) {
    constexpr std::size_t kPortion = std::size_t{1} << 20;
    const std::size_t before = text.size(), given = std::min(rest_.size(), kPortion);
    text.resize(before + kPortion);
    stream_.next_in = const_cast<char*>(rest_.data());
    stream_.avail_in = static_cast<unsigned>(given);
    stream_.next_out = text.data() + before;
    stream_.avail_out = static_cast<unsigned>(kPortion);
    const int code = BZ2_bzDecompress(&stream_);
    rest_.remove_prefix(given - stream_.avail_in);
    text.resize(text.size() - stream_.avail_out);
    if (code == BZ_STREAM_END) return enter_next();
    const bool is_stuck = rest_.empty() && text.size() == before;
    if (code != BZ_OK || is_stuck) {
      throw Error(path_ + ": the bzip2 data is damaged or ends early; bzip2 -t tells more");
    }
    return true;
  }

 private:
  void begin() {
    if (BZ2_bzDecompressInit(&stream_, 0, 0) != BZ_OK) throw std::bad_alloc();
  }

  bool enter_next() {
    if (!starts_with(rest_, kBzip2Magic)) return false;
    BZ2_bzDecompressEnd(&stream_);
    stream_ = {};
    begin();
    return true;
  }

  const std::string& path_;
  std::string_view rest_;
  bz_stream stream_{};
};

std::string unpacked_by_decoder(const std::string& path, const std::string& bytes) {
  Decoder decoder(source_of(bytes));
  std::string text = unpacked(path, [&](std::string& all) {
    constexpr std::size_t kPortion = std::size_t{1} << 16;
    const std::size_t before = all.size();
    all.resize(before + kPortion);
    const std::size_t got = decoder.read(all.data() + before, kPortion);
    all.resize(before + got);
    return got > 0;
  });
  if (decoder.end() != DecodeEnd::kSound) throw Error(path + ": " + decoder.message());
  return text;
}

/// The lines of a log, compressed or not.
class CarmenLines {
 public:
  explicit CarmenLines(const std::string& path) {
    RegularFile file(path);
    std::string head(4, '\0');
    head.resize(file.read(head.data(), head.size()));
    const bool is_bzip2 = starts_with(head, kBzip2Magic);
    if (!is_bzip2 && compression_of(head) == Compression::kNone) {
      reader_ = std::make_unique<TextReader>(path, kCarmenFormat);
      return;
    }
    const std::string bytes = read_file(path, kMostText);
    if (is_bzip2) {
      Bzip2Streams streams(path, bytes);
      text_ = unpacked(path, [&](std::string& text) { return streams.step(text); });
    } else {
      text_ = unpacked_by_decoder(path, bytes);
    }
    reader_ = std::make_unique<TextReader>(text_, path, kCarmenFormat);
  }

  bool next(TextRow& row) { return reader_->next(row); }
  double share() const { return text_.empty() ? reader_->share() : 0; }
  bool is_compressed() const { return !text_.empty(); }

 private:
  std::string text_;
  std::unique_ptr<TextReader> reader_;
};

/// One scan of the log.
struct CarmenScan {
  double time = 0;
  CPose2D robot;  // by odometry
  CPose3D sensor;
  double first_deg = -90, step_deg = 1;
  double max_range = kUsualMaxRange;
  std::vector<double> ranges;
};

CPose2D pose_in(const TextRow& row, std::size_t at) {
  return {row.coordinate(at), row.coordinate(at + 1), row.number(at + 2)};
}

class CarmenImport {
 public:
  CarmenImport(const CarmenOptions& options, const std::string& output)
      : options_(options), log_(output) {}

  ImportReport run() {
    CarmenLines lines(options_.file);
    TextRow row;
    while (lines.next(row)) {
      log_.used(lines.share());
      take(row);
    }
    if (log_.steps() == 0) {
      throw Error(options_.file +
                  ": no line FLASER, ROBOTLASER1 or RAWLASER1: not a CARMEN log "
                  "with a front laser");
    }
    for (const auto& [word, count] : left_out_) {
      log_.note(fmt::format("{} lines {} left out", count, word));
    }
    if (assumes_angle_) {
      log_.note(
          "the log does not say what angle the rays of FLASER lines cover: 180 degrees taken; "
          "--fov says another");
    }
    if (!lines.is_compressed()) log_.note_end(options_.file);
    return log_.finish();
  }

 private:
  void take(const TextRow& row) {
    const std::string_view word = row[0];
    if (word == "PARAM") {
      take_parameter(row);
    } else if (word == "ODOM") {
      row.expect(4, std::numeric_limits<std::size_t>::max(), "ODOM x y theta ...");
      odometry_ = pose_in(row, 1);
    } else if (word == "FLASER") {
      add(front_laser(row));
    } else if (word == "ROBOTLASER1") {
      add(robot_laser(row));
    } else if (word == "RAWLASER1") {
      take_raw_laser(row);
    } else if (word == "RLASER" || word == "ROBOTLASER2" || word == "RAWLASER2") {
      ++left_out_[std::string(word)];
    }
  }

  void take_parameter(const TextRow& row) {
    if (row.size() < 3) return;
    if (row[1] == "laser_front_laser_resolution") step_deg_ = row.number(2);
    if (row[1] == "robot_frontlaser_offset") offset_ = row.coordinate(2);
    if (row[1] == "robot_front_laser_max") max_range_ = row.coordinate(2);
  }

  /// Ranges behind their number in word `at`, and the words behind them; `more` words must follow.
  static std::vector<double> ranges_in(const TextRow& row, std::size_t at, std::size_t more) {
    constexpr std::int64_t kMostRays = 100'000;
    if (row.size() <= at) row.fail(row.size(), "the number of ranges is missing");
    const auto count = static_cast<std::size_t>(row.id(at, kMostRays));
    if (row.size() < at + 1 + count + more) {
      row.fail(row.size(), fmt::format("the line ends early: {} ranges and {} words are expected "
                                       "behind their number",
                                       count, more));
    }
    return row.numbers(at + 1, at + 1 + count);
  }

  CarmenScan front_laser(const TextRow& row) {
    constexpr std::size_t kMore = 9;  // laser pose, odometry, time, host, time of the logger
    CarmenScan scan;
    scan.ranges = ranges_in(row, 1, kMore);
    const std::size_t behind = 2 + scan.ranges.size();
    scan.robot = pose_in(row, behind + 3);
    scan.time = row.time(behind + 6);
    scan.sensor = CPose3D(offset_, 0, 0, 0, 0, 0);
    scan.max_range = max_range_ > 0 ? max_range_ : kUsualMaxRange;
    const std::size_t rays = scan.ranges.size();
    assumes_angle_ = assumes_angle_ || (options_.fov_deg == 0 && step_deg_ == 0);
    if (options_.fov_deg == 0 && step_deg_ > 0) {
      scan.step_deg = step_deg_;
    } else {
      const double angle = options_.fov_deg > 0 ? options_.fov_deg : kHalfTurn;
      const std::size_t steps = rays % 2 == 0 ? rays : rays - 1;
      scan.step_deg = steps > 0 ? angle / static_cast<double>(steps) : 0;
    }
    const std::size_t before_middle = rays / 2;
    scan.first_deg = -scan.step_deg * static_cast<double>(before_middle);
    return scan;
  }

  /// Laser type, angles and ranges that ROBOTLASER1 and RAWLASER1 begin with; `behind` becomes the
  /// word behind them.
  static CarmenScan described_laser(const TextRow& row, std::size_t more, std::size_t& behind) {
    constexpr std::size_t kNumberOfRanges = 8;
    CarmenScan scan;
    scan.ranges = ranges_in(row, kNumberOfRanges, 1 + more);
    scan.first_deg = mrpt::RAD2DEG(row.number(2));
    scan.step_deg = mrpt::RAD2DEG(row.number(4));
    scan.max_range = row.coordinate(5);
    behind = kNumberOfRanges + 1 + scan.ranges.size();
    const std::size_t remissions = ranges_in(row, behind, more).size();
    behind += 1 + remissions;
    return scan;
  }

  static CarmenScan robot_laser(const TextRow& row) {
    constexpr std::size_t kMore = 14;  // two poses, velocities, three distances, times and host
    std::size_t behind = 0;
    CarmenScan scan = described_laser(row, kMore, behind);
    scan.robot = pose_in(row, behind + 3);
    scan.sensor = CPose3D(pose_in(row, behind) - scan.robot);
    scan.time = row.time(behind + 11);
    return scan;
  }

  void take_raw_laser(const TextRow& row) {
    constexpr std::size_t kMore = 3;  // time, host, time of the logger
    std::size_t behind = 0;
    CarmenScan scan = described_laser(row, kMore, behind);
    if (!odometry_) {
      log_.drop("scan dropped: no odometry before it");
      return;
    }
    scan.robot = *odometry_;
    scan.sensor = CPose3D(offset_, 0, 0, 0, 0, 0);
    scan.time = row.time(behind);
    add(std::move(scan));
  }

  void add(CarmenScan scan) {
    if (options_.max_range > 0) scan.max_range = options_.max_range;
    if (scan.ranges.empty()) {
      log_.drop("scan dropped: no rays");
      return;
    }
    if (last_ && scan.time < last_->first) {
      scan.time = last_->first;
      log_.drop("time stamp repaired: it went backwards, that of the scan before taken");
    }
    ImportedStep step{scan.time, {}, {observation_of(scan)}, {}};
    if (last_) step.motion = motion_between(last_->second, scan.robot);
    last_ = {scan.time, scan.robot};
    log_.add(step);
  }

  OdometryIncrement motion_between(const CPose2D& from, const CPose2D& to) const {
    const OdometryWalk& walk = options_.walk;
    const CPose2D mean = to - from;
    const Eigen::Vector3d variances = Eigen::Vector3d::Constant(walk.rest * walk.rest) +
                                      walk.variances(mean.norm(), std::abs(mean.phi()));
    return planar_motion(mean.x(), mean.y(), mean.phi(), variances.asDiagonal());
  }

  /// MRPT's scans look straight ahead in the middle: what is not symmetric turns the sensor.
  static CObservation2DRangeScan::Ptr observation_of(const CarmenScan& scan) {
    auto out = CObservation2DRangeScan::Create();
    const std::size_t rays = scan.ranges.size();
    const double opening = scan.step_deg * static_cast<double>(rays - 1);
    const double middle = mrpt::DEG2RAD(scan.first_deg + opening / 2);
    out->sensorLabel = "LASER";
    out->aperture = static_cast<float>(mrpt::DEG2RAD(opening));
    out->maxRange = static_cast<float>(scan.max_range);
    out->sensorPose = scan.sensor + CPose3D(0, 0, 0, middle, 0, 0);
    out->resizeScan(rays);
    for (std::size_t i = 0; i < rays; ++i) {
      const double range = scan.ranges[i];
      out->setScanRange(i, static_cast<float>(range));
      out->setScanRangeValidity(i, range > 0 && range < scan.max_range);
    }
    return out;
  }

  const CarmenOptions& options_;
  LogWriter log_;
  double step_deg_ = 0, offset_ = 0, max_range_ = 0;  // of PARAM lines; 0: not told
  bool assumes_angle_ = false;
  std::optional<CPose2D> odometry_;  // of the last ODOM line
  std::optional<std::pair<double, CPose2D>> last_;
  std::map<std::string, std::size_t> left_out_;
};

}  // namespace

ImportReport import_carmen(const CarmenOptions& options, const std::string& output) {
  return CarmenImport(options, output).run();
}

}  // namespace hybrid
