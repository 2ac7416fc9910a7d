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

std::string_view LogBytes::peek(std::size_t count) {
  if (ahead_.size() < count) {
    if (!ahead_.empty()) std::memmove(buffer_.get(), ahead_.data(), ahead_.size());
    const std::size_t got =
        decoder_.read(buffer_.get() + ahead_.size(), kAheadBytes - ahead_.size());
    ahead_ = {buffer_.get(), ahead_.size() + got};
  }
  return ahead_.substr(0, count);
}

std::string LogBytes::next_class() {
  const std::string_view head = peek(1 + (kNameFollows - 1));
  if (head.empty()) return "";
  const auto length = static_cast<std::size_t>(head[0] & (kNameFollows - 1));
  const bool is_old = (static_cast<unsigned char>(head[0]) & kNameFollows) == 0;
  const std::string_view name = head.substr(std::min<std::size_t>(head.size(), is_old ? 4 : 1));
  return is_class_name(name.substr(0, length)) ? std::string(name.substr(0, length)) : "";
}

size_t LogBytes::Read(void* to, size_t count) {
  auto* at = static_cast<char*>(to);
  std::size_t done = 0;
  while (done < count) {
    const std::string_view bytes = peek(std::min(count - done, kAheadBytes));
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
