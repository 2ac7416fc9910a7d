// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/log_record.h"

#include <utility>

#include "mrpt_plugins/rawlog/byte_io.h"
#include "mrpt_plugins/rawlog/observation_record.h"

namespace hybrid {
namespace {

enum class RecordKind : std::uint8_t {
  kStarted,
  kParsing,
  kActions,
  kFrame,
  kObservation,
  kPoints,
  kOther,
  kEnd
};

enum class WrittenMotion : std::uint8_t { kNone, kPlane, kSpace };

/// Writes the content of a record and tells its kind.
struct ContentWriter {
  ByteWriter& out;
  const AskedClasses& asked;

  RecordKind operator()(const ParserStarted& started) const {
    out.put_flag(started.is_confined);
    return RecordKind::kStarted;
  }
  RecordKind operator()(const ParsingClass& parsing) const {
    out.put_text(parsing.name);
    return RecordKind::kParsing;
  }
  RecordKind operator()(const LogEnd& end) const {
    out.put(static_cast<std::uint8_t>(end.status));
    out.put_text(end.reason);
    out.put_flag(end.has_trailing_bytes);
    return RecordKind::kEnd;
  }
  RecordKind operator()(const LogObject& object) const { return std::visit(*this, object); }

  RecordKind operator()(const LoggedActions& actions) const {
    write_time(out, actions.time);
    out.put(static_cast<std::uint8_t>(actions.motion.index()));
    std::visit(*this, actions.motion);
    return RecordKind::kActions;
  }
  RecordKind operator()(const LoggedFrame& frame) const {
    out.put(static_cast<std::uint32_t>(frame.observations.size()));
    for (const LoggedObservation& o : frame.observations) write_observation(out, o, asked);
    return RecordKind::kFrame;
  }
  RecordKind operator()(const LoggedObservation& observation) const {
    write_observation(out, observation, asked);
    return RecordKind::kObservation;
  }
  RecordKind operator()(const LoggedPoints& points) const {
    write_points(out, points.points);
    return RecordKind::kPoints;
  }
  RecordKind operator()(const OtherObject& other) const {
    out.put_text(other.class_name);
    return RecordKind::kOther;
  }

  void operator()(std::monostate) const {}
  template <class Distribution>
  void operator()(const Distribution& motion) const {
    write_pose(out, motion.mean);
    write_matrix(out, motion.cov);
  }
};

LoggedActions read_actions(ByteReader& in) {
  LoggedActions actions;
  actions.time = read_time(in);
  const auto kind = static_cast<WrittenMotion>(in.get<std::uint8_t>());
  if (kind == WrittenMotion::kPlane) {
    mrpt::poses::CPosePDFGaussian motion(read_pose_2d(in));
    read_matrix(in, motion.cov);
    actions.motion = motion;
  } else if (kind == WrittenMotion::kSpace) {
    mrpt::poses::CPose3DPDFGaussian motion(read_pose_3d(in));
    read_matrix(in, motion.cov);
    actions.motion = motion;
  } else if (kind != WrittenMotion::kNone) {
    throw Error("a motion is neither in the plane nor in space");
  }
  return actions;
}

LoggedFrame read_frame(ByteReader& in, const AskedClasses& asked) {
  LoggedFrame frame;
  constexpr std::size_t kLeastBytes = 21;  // of an observation without class, label and content
  const std::size_t count = in.count(kLeastBytes);
  for (std::size_t i = 0; i < count; ++i) {
    frame.observations.push_back(read_observation(in, asked));
  }
  return frame;
}

LogEnd read_end(ByteReader& in) {
  LogEnd end;
  const auto status = in.get<std::uint8_t>();
  if (status == 0 || status > static_cast<std::uint8_t>(LogStatus::kTooLarge)) {
    throw Error("a log ends in an unknown way");
  }
  end.status = static_cast<LogStatus>(status);
  end.reason = in.text();
  end.has_trailing_bytes = in.flag();
  return end;
}

LogRecord read_content(RecordKind kind, ByteReader& in, const AskedClasses& asked) {
  switch (kind) {
    case RecordKind::kStarted:
      return ParserStarted{in.flag()};
    case RecordKind::kParsing:
      return ParsingClass{std::string(in.text())};
    case RecordKind::kActions:
      return LogObject(read_actions(in));
    case RecordKind::kFrame:
      return LogObject(read_frame(in, asked));
    case RecordKind::kObservation:
      return LogObject(read_observation(in, asked));
    case RecordKind::kPoints:
      return LogObject(LoggedPoints{read_points(in)});
    case RecordKind::kOther:
      return LogObject(OtherObject{std::string(in.text())});
    case RecordKind::kEnd:
      return read_end(in);
  }
  throw Error("it is of an unknown kind");
}

}  // namespace

const char* to_string(LogStatus status) {
  switch (status) {
    case LogStatus::kReading:
      return "reading";
    case LogStatus::kComplete:
      return "complete";
    case LogStatus::kEmpty:
      return "empty";
    case LogStatus::kNotARawlog:
      return "not a rawlog";
    case LogStatus::kTruncated:
      return "truncated";
    case LogStatus::kCorrupt:
      return "corrupt";
    case LogStatus::kUnregisteredClass:
      return "unregistered class";
    case LogStatus::kTooLarge:
      return "too large";
  }
  return "unknown";
}

std::string to_bytes(const LogRecord& record, const AskedClasses& asked) {
  ByteWriter content;
  const RecordKind kind = std::visit(ContentWriter{content, asked}, record);
  ByteWriter whole;
  whole.put(static_cast<std::uint64_t>(content.bytes().size()));
  whole.put(static_cast<std::uint8_t>(kind));
  return whole.bytes() + content.bytes();
}

void RecordReader::add(std::string_view bytes) {
  bytes_.erase(0, std::exchange(used_, 0));
  bytes_.append(bytes);
}

std::optional<LogRecord> RecordReader::next() {
  constexpr std::size_t kHeadBytes = sizeof(std::uint64_t) + sizeof(std::uint8_t);
  std::string_view rest = std::string_view(bytes_).substr(used_);
  if (rest.size() < kHeadBytes) return std::nullopt;
  ByteReader head(rest.substr(0, kHeadBytes));
  const auto size = head.get<std::uint64_t>();
  const auto kind = static_cast<RecordKind>(head.get<std::uint8_t>());
  if (size > most_) throw Error("it is larger than the parser may be");
  rest.remove_prefix(kHeadBytes);
  if (rest.size() < size) return std::nullopt;
  ByteReader content(rest.substr(0, size));
  LogRecord record = read_content(kind, content, asked_);
  content.expect_end();
  used_ += kHeadBytes + size;
  return record;
}

}  // namespace hybrid
