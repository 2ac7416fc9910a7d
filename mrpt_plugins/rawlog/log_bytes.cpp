// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/detail/log_bytes.h"

#include <algorithm>
#include <cstring>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

constexpr std::size_t kAheadBytes = std::size_t{1} << 16;

/// MRPT writes an object as the length of the name of its class with the highest bit set, the name,
/// the version and the content.
constexpr unsigned char kNameFollows = 0x80;

constexpr std::size_t kLongestName = 120;  // that MRPT accepts

}  // namespace

bool is_class_name(std::string_view text) {
  return !text.empty() && text.size() <= kLongestName &&
         std::all_of(text.begin(), text.end(), [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                  c == '_' || c == ':';
         });
}

LogBytes::LogBytes(Decoder& decoder) : decoder_(decoder), buffer_(new char[kAheadBytes]) {}

std::string_view LogBytes::peek(std::size_t least) {
  if (ahead_.size() >= least) return ahead_;
  if (!ahead_.empty()) std::memmove(buffer_.get(), ahead_.data(), ahead_.size());
  std::size_t size = ahead_.size(), got = 0;
  do {
    got = decoder_.read(buffer_.get() + size, kAheadBytes - size);
    size += got;
  } while (got > 0 && size < least);
  return ahead_ = {buffer_.get(), size};
}

std::string LogBytes::next_class() {
  const std::string_view head = peek(1);
  if (head.empty()) return "";
  const auto length = static_cast<std::size_t>(head[0] & (kNameFollows - 1));
  const bool is_old = (static_cast<unsigned char>(head[0]) & kNameFollows) == 0;
  const std::size_t before = is_old ? 4 : 1;
  std::string_view name = peek(before + length).substr(0, before + length);
  name.remove_prefix(std::min(name.size(), before));
  return is_class_name(name) ? std::string(name) : "";
}

size_t LogBytes::Read(void* to, size_t count) {
  auto* at = static_cast<char*>(to);
  std::size_t done = 0;
  while (done < count) {
    const std::string_view bytes = peek(1).substr(0, count - done);
    if (bytes.empty()) break;
    std::memcpy(at + done, bytes.data(), bytes.size());
    ahead_.remove_prefix(bytes.size());
    done += bytes.size();
  }
  position_ += done;
  watch({at, done});
  return done;
}

void LogBytes::watch(std::string_view bytes) {
  if (name_bytes_ > 0 && bytes.size() == name_bytes_ && on_class && is_class_name(bytes)) {
    on_class(std::string(bytes));
  }
  const bool announces =
      bytes.size() == 1 && (static_cast<unsigned char>(bytes[0]) & kNameFollows) != 0;
  name_bytes_ = announces ? static_cast<std::size_t>(bytes[0] & (kNameFollows - 1)) : 0;
}

size_t LogBytes::Write(const void*, size_t) {
  throw Error("a rawlog is open for reading only");
}

std::uint64_t LogBytes::Seek(std::int64_t, TSeekOrigin) {
  throw Error("a rawlog is read from start to end");
}

std::uint64_t LogBytes::getTotalBytesCount() const {
  throw Error("the size of a rawlog is not known beforehand");
}

}  // namespace hybrid
