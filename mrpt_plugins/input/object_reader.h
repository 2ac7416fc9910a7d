// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/serialization/CArchive.h>
#include <mrpt/serialization/CSerializable.h>

#include <cstdint>
#include <memory>
#include <string>

#include "mrpt_plugins/input/gzip_file.h"

namespace hybrid {

enum class LogStatus {
  kReading,            ///< Not at the end yet.
  kComplete,           ///< Read to the end, nothing wrong.
  kEmpty,              ///< The file holds no object.
  kNotARawlog,         ///< Not even the first object can be read.
  kTruncated,          ///< The file ends inside an object or inside the compressed stream.
  kCorrupt,            ///< An object cannot be read, or a checksum is wrong.
  kUnregisteredClass,  ///< An object of a class this program does not know.
};

/// "complete", "empty", "not a rawlog", ...
const char* to_string(LogStatus status);

/// The objects of a rawlog one after the other, each whole or not at all.
///
/// MRPT's own readers report a damaged log as a good one that ends early. Here the whole file is
/// first passed through zlib, whose checksum finds nearly all damage of a compressed log. A log
/// that fails there, or that is not compressed, may crash MRPT's parsers: it is first parsed in a
/// child process with bounded memory, and this process reads only the objects the child survived.
class ObjectReader {
 public:
  /// Throws Error if the file is missing or cannot be opened.
  explicit ObjectReader(const std::string& path);

  /// The next object, or null at the end; status() then says why it is the end.
  mrpt::serialization::CSerializable::Ptr next();

  LogStatus status() const { return status_; }
  /// One line for the user: what happened, at which object, what to do. Empty while reading and
  /// when complete.
  const std::string& message() const { return message_; }
  /// Objects read so far; a fault is "at object N" counted from 0.
  std::uint64_t objects() const { return objects_; }
  /// Fraction of the file read.
  double progress() const;

 private:
  struct Trial;

  Trial try_in_child() const;
  void finish(LogStatus status, const std::string& why);
  void finish_at_end();
  void finish_failed(const std::string& what);

  std::string path_;
  GzipCheck check_;
  GzipStream stream_;
  mrpt::serialization::CArchive::UniquePtr archive_;
  LogStatus status_ = LogStatus::kReading;
  std::string message_;
  std::uint64_t objects_ = 0;
  std::uint64_t file_bytes_ = 0;
  std::uint64_t safe_objects_;  // the child process got this far
  std::string child_message_;
};

}  // namespace hybrid
