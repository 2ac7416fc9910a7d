// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/io/CStream.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "mrpt_plugins/rawlog/decoder.h"

namespace hybrid {

/// Whether a text can be the name of a class of MRPT's.
bool is_class_name(std::string_view text);

/// A decoded log as MRPT's parsers read it: forwards only, with a look ahead, and with an eye on
/// the objects that they meet.
class LogBytes : public mrpt::io::CStream {
 public:
  explicit LogBytes(Decoder& decoder);

  /// The bytes that come next: `least`, which is 64 KiB at most, and all else that is there without
  /// waiting for it; fewer only at the end.
  std::string_view peek(std::size_t least);

  bool is_at_end() { return peek(1).empty(); }

  /// Name of the class of the object that comes next; empty where none can be told.
  std::string next_class();

  /// Called with the name of a class where one has just been read, as at the start of every object,
  /// those inside of others included.
  std::function<void(const std::string&)> on_class;

  size_t Read(void* to, size_t count) override;
  std::uint64_t getPosition() const override { return position_; }
  std::string getStreamDescription() const override { return "rawlog"; }

  /// Unsupported: these throw Error.
  size_t Write(const void* from, size_t count) override;
  std::uint64_t Seek(std::int64_t offset, TSeekOrigin origin) override;
  std::uint64_t getTotalBytesCount() const override;

 private:
  void watch(std::string_view bytes);

  Decoder& decoder_;
  std::unique_ptr<char[]> buffer_;
  std::string_view ahead_;  // part of the buffer that has not been read yet
  std::uint64_t position_ = 0;
  std::size_t name_bytes_ = 0;  // of a class, if the last read was the number of them
};

}  // namespace hybrid
