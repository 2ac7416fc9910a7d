// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/object_reader.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <mrpt/maps/registerAllClasses.h>
#include <mrpt/obs/registerAllClasses.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <limits>
#include <optional>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();
constexpr rlim_t kChildBytes = rlim_t{4} << 30;

/// The innermost reason in an MRPT exception text, which nests messages and call stacks.
std::string root_cause(const std::string& what) {
  const std::string mark = "Message:";
  const std::size_t at = what.rfind(mark);
  std::string text = at == std::string::npos ? what : what.substr(at + mark.size());
  text = text.substr(0, text.find('\n'));
  text.erase(0, text.find_first_not_of(' '));
  return text;
}

/// The X of "Stored object has class 'X' which is not registered!", if X can be a class name.
std::optional<std::string> unregistered_class(const std::string& cause) {
  const std::string before = "has class '", after = "' which is not registered";
  const std::size_t begin = cause.find(before);
  const std::size_t end = cause.find(after);
  if (begin == std::string::npos || end == std::string::npos) return std::nullopt;
  const std::string name = cause.substr(begin + before.size(), end - begin - before.size());
  const bool plausible = !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == ':';
  });
  return plausible ? std::optional(name) : std::nullopt;
}

}  // namespace

/// What a child process reports through shared memory.
struct ObjectReader::Trial {
  std::uint64_t objects = 0;
  bool finished = false;
  int status = 0;
};

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
  }
  return "unknown";
}

ObjectReader::ObjectReader(const std::string& path)
    : path_(path), check_(check_gzip(path)), stream_(path), safe_objects_(kNoLimit) {
  // The linker drops MRPT libraries that are used through class names alone.
  mrpt::obs::registerAllClasses_mrpt_obs();
  mrpt::maps::registerAllClasses_mrpt_maps();
  archive_ = mrpt::serialization::archiveUniquePtrFrom<mrpt::io::CStream>(stream_);
  file_bytes_ = std::filesystem::file_size(path);
  if (check_.is_gzip && check_.state != GzipCheck::State::kDamaged) return;
  const Trial trial = try_in_child();
  if (trial.finished) return;
  safe_objects_ = trial.objects;
  child_message_ = WIFSIGNALED(trial.status)
                       ? fmt::format("parsing it crashes ({})", strsignal(WTERMSIG(trial.status)))
                       : "parsing it crashes";
}

ObjectReader::Trial ObjectReader::try_in_child() const {
  void* memory =
      mmap(nullptr, sizeof(Trial), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw Error(fmt::format("mmap failed: {}", std::strerror(errno)));
  auto* shared = new (memory) Trial;
  const pid_t child = fork();
  if (child == 0) {
    const int null = open("/dev/null", O_WRONLY);
    dup2(null, STDERR_FILENO);
#ifndef __SANITIZE_ADDRESS__
    const rlimit limit{kChildBytes, kChildBytes};
    setrlimit(RLIMIT_DATA, &limit);
#endif
    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
    try {
      GzipStream stream(path_);
      auto archive = mrpt::serialization::archiveFrom<mrpt::io::CStream>(stream);
      for (;; ++shared->objects) archive.ReadObject();
    } catch (const std::bad_alloc&) {
      _exit(1);
    } catch (const std::exception&) {
      shared->finished = true;
    }
    _exit(0);
  }
  if (child > 0) waitpid(child, &shared->status, 0);
  const Trial trial = *shared;
  munmap(memory, sizeof(Trial));
  if (child < 0) throw Error(fmt::format("fork failed: {}", std::strerror(errno)));
  return trial;
}

mrpt::serialization::CSerializable::Ptr ObjectReader::next() {
  if (status_ != LogStatus::kReading) return nullptr;
  if (stream_.getPosition() >= check_.bytes) {
    finish_at_end();
    return nullptr;
  }
  if (objects_ >= safe_objects_) {
    finish(LogStatus::kCorrupt, child_message_);
    return nullptr;
  }
  try {
    auto object = archive_->ReadObject();
    ++objects_;
    return object;
  } catch (const std::exception& e) {
    finish_failed(root_cause(e.what()));
    return nullptr;
  }
}

void ObjectReader::finish(LogStatus status, const std::string& why) {
  status_ = status;
  message_ = status == LogStatus::kComplete
                 ? ""
                 : fmt::format("{}: {} at object {}: {}", path_, to_string(status), objects_, why);
}

void ObjectReader::finish_at_end() {
  if (check_.state == GzipCheck::State::kTruncated) {
    finish(LogStatus::kTruncated, check_.message);
  } else if (check_.state == GzipCheck::State::kDamaged) {
    finish(LogStatus::kCorrupt, check_.message);
  } else if (objects_ == 0) {
    finish(LogStatus::kEmpty, "the file holds nothing");
  } else {
    finish(LogStatus::kComplete, "");
  }
}

void ObjectReader::finish_failed(const std::string& cause) {
  const bool ends_early = stream_.hit_end() || stream_.getPosition() >= check_.bytes;
  if (const auto name = unregistered_class(cause)) {
    finish(LogStatus::kUnregisteredClass,
           fmt::format("class '{}' is not known; load the plugin that defines it with -p", *name));
  } else if (check_.state == GzipCheck::State::kDamaged) {
    finish(LogStatus::kCorrupt, fmt::format("{} ({})", check_.message, cause));
  } else if (check_.state == GzipCheck::State::kTruncated) {
    finish(LogStatus::kTruncated, check_.message);
  } else if (objects_ == 0) {
    finish(LogStatus::kNotARawlog, fmt::format("no MRPT object found ({})", cause));
  } else if (ends_early) {
    finish(LogStatus::kTruncated, "the file ends inside an object");
  } else {
    finish(LogStatus::kCorrupt, cause);
  }
}

double ObjectReader::progress() const {
  if (status_ != LogStatus::kReading || file_bytes_ == 0) return 1.0;
  return std::min(
      1.0, static_cast<double>(stream_.compressed_position()) / static_cast<double>(file_bytes_));
}

}  // namespace hybrid
