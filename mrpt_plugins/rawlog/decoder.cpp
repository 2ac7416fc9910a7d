// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/decoder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

#include "libhybrid/io/regular_file.h"
#include "mrpt_plugins/rawlog/detail/inflater.h"

namespace hybrid {
namespace {

constexpr std::size_t kInputBytes = std::size_t{1} << 16;
constexpr std::size_t kMagicBytes = 4;  // that tell the compression

}  // namespace

ByteSource source_of(std::string_view bytes) {
  return [bytes](char* to, std::size_t count) mutable {
    const std::size_t given = bytes.copy(to, count);
    bytes.remove_prefix(given);
    return given;
  };
}

Decoder::Decoder(ByteSource source, const InflationLimit& limit)
    : source_(std::move(source)), limit_(limit), buffer_(new char[kInputBytes]) {
  load();
  compression_ = compression_of(input_);
  inflater_ = make_inflater(compression_);
}

Decoder::~Decoder() = default;

/// Fills the buffer behind what is left in it until it holds enough to tell a member.
void Decoder::load() {
  if (!input_.empty()) std::memmove(buffer_.get(), input_.data(), input_.size());
  std::size_t size = input_.size();
  while (!at_end_ && size < kMagicBytes) {
    const std::size_t got = source_(buffer_.get() + size, kInputBytes - size);
    at_end_ = got == 0;
    size += got;
    read_ += got;
  }
  input_ = {buffer_.get(), size};
}

std::size_t Decoder::read(char* to, std::size_t count) {
  std::size_t done = 0;
  while (done == 0 && count > 0 && end_ == DecodeEnd::kNone) {
    done = inflater_ ? inflate(to, count) : copy(to, count);
  }
  return done;
}

std::size_t Decoder::copy(char* to, std::size_t count) {
  if (input_.empty()) load();
  if (input_.empty()) finish(DecodeEnd::kSound);
  const std::size_t given = input_.copy(to, count);
  input_.remove_prefix(given);
  return given;
}

/// One step; gives what it decoded.
std::size_t Decoder::inflate(char* to, std::size_t count) {
  if (!in_member_ && !enter_member()) return 0;
  if (input_.empty() && !holds_more_) load();
  const std::size_t input_before = input_.size();
  std::size_t room = count;
  const Inflater::Step step = inflater_->step(input_, to, room);
  const std::size_t given = count - room;
  given_ += given;
  holds_more_ = room == 0;
  if (step == Inflater::Step::kMemberEnds) {
    in_member_ = false;
  } else if (step == Inflater::Step::kFault) {
    finish(DecodeEnd::kDamaged,
           fmt::format("the compressed file is damaged: {}", inflater_->fault()));
  } else if (given == 0 && input_.size() == input_before && at_end_) {
    finish(DecodeEnd::kTruncated, "the compressed file ends early");
  }
  const std::uint64_t used = read_ - input_.size();
  if (given_ > limit_.free_bytes + limit_.ratio * used) {
    finish(DecodeEnd::kTooLarge,
           fmt::format("what is compressed grows to more than {} MB and {} times its size, as no "
                       "log does; if it is meant, decompress the file first",
                       limit_.free_bytes >> 20, limit_.ratio));
  }
  return given;
}

/// Whether another member follows; the end of the stream otherwise.
bool Decoder::enter_member() {
  if (input_.size() < kMagicBytes) load();
  if (!inflater_->begins(input_)) {
    has_trailing_bytes_ = !input_.empty();
    finish(DecodeEnd::kSound);
    return false;
  }
  inflater_->reset();
  in_member_ = true;
  return true;
}

void Decoder::finish(DecodeEnd end, const std::string& message) {
  end_ = end;
  message_ = message;
}

std::string decoding_fault(const std::string& path) {
  RegularFile file(path);
  const InflationLimit none{std::numeric_limits<std::uint64_t>::max(), 0};
  Decoder decoder([&](char* to, std::size_t count) { return file.read(to, count); }, none);
  std::string buffer(kInputBytes, '\0');
  while (decoder.read(buffer.data(), buffer.size()) > 0) {
  }
  return decoder.message();
}

}  // namespace hybrid
