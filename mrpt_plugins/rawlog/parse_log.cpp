// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/detail/parse_log.h"

#include <fmt/format.h>
#include <mrpt/obs/CAction.h>
#include <mrpt/obs/CObservation.h>
#include <mrpt/serialization/CArchive.h>

#include <new>
#include <optional>
#include <string>

#include "mrpt_plugins/rawlog/detail/convert_object.h"
#include "mrpt_plugins/rawlog/detail/log_bytes.h"
#include "mrpt_plugins/rawlog/foreign_file.h"

namespace hybrid {
namespace {

constexpr std::size_t kHeadBytes = 1024;  // that tell what a file is

/// The innermost reason in an MRPT exception text, which nests messages and call stacks.
std::string root_cause(const std::string& what) {
  const std::string mark = "Message:";
  const std::size_t at = what.rfind(mark);
  std::string text = at == std::string::npos ? what : what.substr(at + mark.size());
  text = text.substr(0, text.find('\n'));
  text.erase(0, text.find_first_not_of(' '));
  return text;
}

/// The X of "Stored object has class 'X' which is not registered!".
std::optional<std::string> unregistered_class(const std::string& cause) {
  const std::string before = "has class '", after = "' which is not registered";
  const std::size_t begin = cause.find(before);
  const std::size_t end = cause.find(after);
  if (begin == std::string::npos || end == std::string::npos) return std::nullopt;
  const std::string name = cause.substr(begin + before.size(), end - begin - before.size());
  return is_class_name(name) ? std::optional(name) : std::nullopt;
}

/// Whether objects of a class are what frames and collections of actions hold.
bool is_entry(const std::string& class_name) {
  const auto* id = mrpt::rtti::findRegisteredClass(class_name);
  return id != nullptr && (id->derivedFrom(CLASS_ID(mrpt::obs::CObservation)) ||
                           id->derivedFrom(CLASS_ID(mrpt::obs::CAction)));
}

/// How a log ends whose decoded bytes end before an object.
LogEnd end_between(const Decoder& decoder, std::uint64_t objects) {
  switch (decoder.end()) {
    case DecodeEnd::kTruncated:
      return {LogStatus::kTruncated, decoder.message()};
    case DecodeEnd::kDamaged:
      return {LogStatus::kCorrupt, decoder.message()};
    case DecodeEnd::kTooLarge:
      return {LogStatus::kTooLarge, decoder.message()};
    default:
      break;
  }
  if (objects == 0) return {LogStatus::kEmpty, "the file holds nothing"};
  return {LogStatus::kComplete, "", decoder.has_trailing_bytes()};
}

/// How a log ends in an object that cannot be parsed for `cause`.
LogEnd end_inside(const Decoder& decoder, LogBytes& bytes, std::uint64_t objects,
                  const std::string& cause) {
  if (const auto name = unregistered_class(cause)) {
    return {LogStatus::kUnregisteredClass,
            fmt::format("class '{}' is not known; load the plugin that defines it with -p", *name)};
  }
  const bool sound = decoder.end() == DecodeEnd::kNone || decoder.end() == DecodeEnd::kSound;
  if (!sound && bytes.is_at_end()) return end_between(decoder, objects);
  if (decoder.end() == DecodeEnd::kDamaged) {
    return {LogStatus::kCorrupt, fmt::format("{} ({})", decoder.message(), cause)};
  }
  if (objects == 0) {
    return {LogStatus::kNotARawlog, fmt::format("no MRPT object found ({})", cause)};
  }
  if (bytes.is_at_end()) return {LogStatus::kTruncated, "the file ends inside an object"};
  return {LogStatus::kCorrupt, cause};
}

class Parser {
 public:
  Parser(const ByteSource& file, const LogRequest& request,
         const std::function<void(const LogRecord&)>& give)
      : decoder_(file), bytes_(decoder_), request_(request), give_(give) {
    bytes_.on_class = [this](const std::string& name) {
      if (name != parsing_ && is_entry(name)) announce(name);
    };
  }

  LogEnd run() {
    const std::string kind = foreign_kind(bytes_.peek(1).substr(0, kHeadBytes));
    if (!kind.empty()) return {LogStatus::kNotARawlog, kind};
    while (!bytes_.is_at_end()) {
      if (const std::optional<LogEnd> end = parse_object()) return *end;
    }
    return end_between(decoder_, objects_);
  }

 private:
  void announce(const std::string& class_name) {
    parsing_ = class_name;
    give_(ParsingClass{class_name});
  }

  /// A simple map is a log of its keyframes, unless points are wanted.
  void give_object(const mrpt::serialization::CSerializable::Ptr& object) {
    const auto* map = dynamic_cast<const mrpt::maps::CSimpleMap*>(object.get());
    if (map == nullptr || request_.points) {
      give_(convert_object(object, request_.points));
      return;
    }
    for (const LogObject& part : keyframes_of(*map)) give_(part);
  }

  /// The end, if the object cannot be parsed.
  std::optional<LogEnd> parse_object() {
    announce(bytes_.next_class());
    try {
      const auto archive = mrpt::serialization::archiveUniquePtrFrom<mrpt::io::CStream>(bytes_);
      give_object(archive->ReadObject());
    } catch (const std::exception& e) {
      const std::string what = e.what();
      if (what.find("std::bad_alloc") != std::string::npos) throw std::bad_alloc();
      return end_inside(decoder_, bytes_, objects_, root_cause(what));
    }
    ++objects_;
    return std::nullopt;
  }

  Decoder decoder_;
  LogBytes bytes_;
  const LogRequest& request_;
  const std::function<void(const LogRecord&)>& give_;
  std::uint64_t objects_ = 0;
  std::string parsing_;  // the class told last
};

}  // namespace

void parse_log(const ByteSource& file, const LogRequest& request,
               const std::function<void(const LogRecord&)>& give) {
  give(Parser(file, request, give).run());
}

}  // namespace hybrid
