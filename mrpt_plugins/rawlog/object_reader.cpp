// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/object_reader.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/io/escaped.h"
#include "libhybrid/io/point_formats.h"
#include "mrpt_plugins/bridge/interrupt.h"
#include "mrpt_plugins/bridge/log_files.h"
#include "mrpt_plugins/bridge/standard_input.h"
#include "mrpt_plugins/observations/logged_cloud.h"
#include "mrpt_plugins/rawlog/detail/depth_files.h"

namespace hybrid {
namespace {

/// Longest wait for one object, and for the process to start on a busy machine [s].
constexpr int kObjectSeconds = 15, kStartSeconds = 60;

/// The classes of a request, once MRPT's own are registered.
AskedClasses asked_classes(const LogRequest& request) {
  register_mrpt_classes();
  return AskedClasses(request.classes);
}

/// Tells a file, as it is now, and what is asked of it from all others; empty for what is no file.
std::string key_of(const LogInput& input, const LogRequest& request) {
  struct stat file {};
  if (!input.size() || ::fstat(input.descriptor(), &file) != 0) return {};
  return fmt::format("{} {} {} {}.{} {} {}", file.st_dev, file.st_ino, file.st_size,
                     file.st_mtim.tv_sec, file.st_mtim.tv_nsec, request.points,
                     fmt::join(request.classes, " "));
}

constexpr std::uintmax_t kMostBytesBeside = std::uintmax_t{1} << 30;

/// The first map of points in a file.
PointFile read_map_of_mrpt(const std::string& path) {
  LogRequest request;
  request.points = true;
  ObjectReader reader(path, request);
  while (const auto object = reader.next()) {
    const auto* map = std::get_if<LoggedPoints>(&*object);
    if (map == nullptr) continue;
    PointFile file;
    for (const auto& p : map->points) add_point(file, {p.x, p.y, p.z}, path);
    return file;
  }
  throw Error(reader.message());
}

PointFile read_cloud_file(const std::string& path, const LoggedCloud& cloud) {
  switch (cloud.form) {
    case CloudForm::kKitti:
      return read_kitti(path);
    case CloudForm::kText:
      return read_rows(path);
    case CloudForm::kMrpt:
      return read_map_of_mrpt(path);
    case CloudForm::kCoordinates:
      return read_coordinates(path);
    case CloudForm::kRanges:
      return unprojected(read_ranges(path), cloud.camera);
    default:
      throw Error(path + ": of an unknown form");
  }
}

void read_beside(LoggedCloud& cloud, const std::string& rawlog) try {
  const auto path = named_file(cloud.file, rawlog, kMostBytesBeside);
  if (!path) {
    cloud.fault = "cloud dropped: its file is not in the folder of images beside the log";
    return;
  }
  const auto map = mrpt::maps::CSimplePointsMap::Create();
  for (const Eigen::Vector3d& point : read_cloud_file(path->string(), cloud).points) {
    const Eigen::Vector3f p = point.cast<float>();
    map->insertPointFast(p.x(), p.y(), p.z());
  }
  cloud.pointcloud = map;
} catch (const Interrupted&) {
  throw;
} catch (const Error&) {
  cloud.fault = "cloud dropped: its file beside the log cannot be read";
}

void read_beside(const LoggedObservation& observation, const std::string& rawlog) {
  auto* cloud = dynamic_cast<LoggedCloud*>(observation.content.get());
  if (cloud != nullptr && !cloud->file.empty()) read_beside(*cloud, rawlog);
}

/// Reads the points of clouds that are in files beside the log F.rawlog: those of its folder
/// F_Images, or else Images, of at most 1 GiB (bridge/log_files.h, named_file()). KITTI's form,
/// text, and what MRPT writes of depth cameras, of at most ten million points, are read here; maps
/// that MRPT serialised in the process that parses logs. Where a file is not there or damaged, the
/// cloud has none, and its fault is the reason.
void read_clouds_beside(LogObject& object, const std::string& rawlog) {
  if (const auto* observation = std::get_if<LoggedObservation>(&object)) {
    read_beside(*observation, rawlog);
  } else if (const auto* frame = std::get_if<LoggedFrame>(&object)) {
    for (const LoggedObservation& seen : frame->observations) read_beside(seen, rawlog);
  }
}

}  // namespace

LogInput::LogInput(const std::string& path) : name_(shown_path(path)) {
  struct stat status {};
  if (!is_standard_input(path)) {
    if (::stat(path.c_str(), &status) == 0 && S_ISFIFO(status.st_mode)) {
      throw Error(path + ": is a pipe; it is read as standard input: --rawlog - <" + path);
    }
    file_.emplace(path);
    return;
  }
  if (::isatty(STDIN_FILENO) == 1) {
    throw Error(name_ + ": is a terminal; pipe a log into it, or name a file");
  }
  if (::fstat(STDIN_FILENO, &status) == 0 && S_ISDIR(status.st_mode)) {
    throw Error(name_ + ": is a folder, not a file");
  }
}

int LogInput::descriptor() const {
  return file_ ? file_->descriptor() : STDIN_FILENO;
}

std::optional<std::uint64_t> LogInput::size() const {
  return file_ ? std::make_optional(file_->size()) : std::nullopt;
}

ObjectReader::ObjectReader(const std::string& path, const LogRequest& request,
                           const std::vector<std::string>& libraries)
    : input_(path),
      asked_(asked_classes(request)),
      limits_(parser_limits(input_.size())),
      records_(asked_, limits_.memory),
      logs_(request.parsed),
      key_(key_of(input_, request)) {
  if (logs_ && !key_.empty()) parsed_ = logs_->find(key_);
  if (parsed_) return;
  process_.emplace(input_.descriptor(), limits_, request, libraries);
  if (logs_ && !key_.empty()) keeping_ = logs_->begin(*input_.size());
}

std::optional<LogObject> ObjectReader::next() {
  while (status_ == LogStatus::kReading) {
    std::optional<LogRecord> record = next_record();
    if (!record) break;
    if (auto* object = std::get_if<LogObject>(&*record)) {
      ++objects_;
      if (input_.size()) read_clouds_beside(*object, input_.name());
      return std::move(*object);
    }
    take(*record);
  }
  return std::nullopt;
}

/// The next record; nothing where the process has ended, was too slow or sends something else.
std::optional<LogRecord> ObjectReader::next_record() {
  std::string bytes;
  while (true) {
    try {
      if (auto record = records_.next()) return record;
    } catch (const std::exception& e) {
      finish(LogStatus::kCorrupt, fmt::format("the parser sent what is no record: {}", e.what()));
      return std::nullopt;
    }
    const auto got = read(bytes);
    if (got == ParserProcess::Got::kBytes) {
      records_.add(bytes);
    } else {
      finish_early(got == ParserProcess::Got::kNothing);
      return std::nullopt;
    }
  }
}

/// Some of what the parser tells, or told before.
ParserProcess::Got ObjectReader::read(std::string& bytes) {
  if (parsed_) {
    bytes = parsed_->read(parsed_at_);
    parsed_at_ += bytes.size();
    return bytes.empty() ? ParserProcess::Got::kEnd : ParserProcess::Got::kBytes;
  }
  const auto got = process_->read(bytes, is_started_ ? kObjectSeconds : kStartSeconds);
  if (got == ParserProcess::Got::kBytes && keeping_ && !keeping_->add(bytes)) keeping_.reset();
  return got;
}

void ObjectReader::take(const LogRecord& record) {
  if (const auto* started = std::get_if<ParserStarted>(&record)) {
    is_started_ = true;
    if (started->is_confined) return;
    notes_.emplace_back(
        "the kernel filters no system calls (seccomp): the log was parsed under limits on memory, "
        "time and open files alone");
  } else if (const auto* parsing = std::get_if<ParsingClass>(&record)) {
    parsing_ = parsing->name;
  } else if (const auto* end = std::get_if<LogEnd>(&record)) {
    if (end->has_trailing_bytes) {
      notes_.emplace_back("bytes behind the compressed log were left out");
    }
    if (keeping_) logs_->keep(key_, std::move(keeping_));
    finish(end->status, end->reason);
  }
}

void ObjectReader::finish(LogStatus status, const std::string& why) {
  status_ = status;
  if (status == LogStatus::kComplete) return;
  const bool is_inside = status != LogStatus::kEmpty && status != LogStatus::kNotARawlog;
  message_ = fmt::format("{}: {}{}: {}", input_.name(), to_string(status),
                         is_inside ? fmt::format(" at object {}", objects_) : "", escaped(why));
  if ((status == LogStatus::kCorrupt || status == LogStatus::kTooLarge) && objects_ > 0) {
    message_ += "; what came before it was used, but may be damaged too";
  }
}

/// The process has ended, or is not answering, without telling how the log ends.
void ObjectReader::finish_early(bool is_silent) {
  const std::string object = parsing_.empty() ? "" : fmt::format(" ({})", escaped(parsing_));
  if (is_silent) {
    finish(LogStatus::kTooLarge,
           fmt::format("parsing it takes more than {} s{}", kObjectSeconds, object));
    return;
  }
  if (!process_) throw Error(input_.name() + ": what was kept of it is cut off");
  switch (process_->wait()) {
    case ParserProcess::Exit::kOutOfMemory:
      finish(LogStatus::kTooLarge,
             fmt::format("parsing it takes more than {} MB, which points to damage{}",
                         limits_.memory >> 20, object));
      return;
    case ParserProcess::Exit::kOutOfTime:
      finish(LogStatus::kTooLarge,
             fmt::format("parsing up to it takes more than {} s of processor time{}",
                         limits_.seconds, object));
      return;
    default:
      break;
  }
  if (!is_started_) throw Error(input_.name() + ": the process that parses it could not start");
  finish(LogStatus::kCorrupt, fmt::format("MRPT's parser crashed{}", object));
}

std::optional<double> ObjectReader::progress() const {
  const auto size = input_.size();
  if (status_ != LogStatus::kReading || size == 0) return 1.0;
  if (!size) return std::nullopt;
  if (parsed_) return double(parsed_at_) / double(parsed_->size());
  const auto at =
      static_cast<double>(std::max<off_t>(0, ::lseek(input_.descriptor(), 0, SEEK_CUR)));
  return std::min(1.0, at / static_cast<double>(*size));
}

}  // namespace hybrid
