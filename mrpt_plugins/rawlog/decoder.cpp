// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/decoder.h"

#include <fmt/format.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <new>
#include <utility>

#include "libhybrid/io/regular_file.h"
#include "mrpt_plugins/rawlog/byte_io.h"

namespace hybrid {

/// A compression method, member by member.
class Inflater {
 public:
  enum class Step { kMore, kMemberEnds, kFault };

  virtual ~Inflater() = default;

  /// Whether these bytes begin a member; up to four are looked at.
  virtual bool begins(std::string_view head) const = 0;

  /// Forgets the member before.
  virtual void reset() = 0;

  /// Takes bytes from the front of `input` and appends the decoded ones at `to`, of which `room`
  /// are left; both are moved on.
  virtual Step step(std::string_view& input, char*& to, std::size_t& room) = 0;

  /// What the last fault was.
  virtual std::string fault() const = 0;
};

namespace {

constexpr std::size_t kInputBytes = std::size_t{1} << 16;
constexpr std::size_t kMagicBytes = 4;  // that tell the compression

constexpr std::string_view kGzipMagic("\x1f\x8b", 2);
constexpr std::string_view kZstdMagic("\x28\xb5\x2f\xfd", 4);
constexpr std::string_view kZstdSkippable("\x2a\x4d\x18", 3);  // behind a byte 0x50 .. 0x5f

bool begins_zstd(std::string_view head) {
  return starts_with(head, kZstdMagic) ||
         (!head.empty() && (head[0] & 0xf0) == 0x50 && starts_with(head.substr(1), kZstdSkippable));
}

class GzipInflater : public Inflater {
 public:
  GzipInflater() {
    constexpr int kGzipOnly = 16;
    if (inflateInit2(&state_, MAX_WBITS + kGzipOnly) != Z_OK) throw std::bad_alloc();
  }
  ~GzipInflater() override { inflateEnd(&state_); }
  GzipInflater(const GzipInflater&) = delete;
  GzipInflater& operator=(const GzipInflater&) = delete;

  bool begins(std::string_view head) const override { return starts_with(head, kGzipMagic); }
  void reset() override { inflateReset(&state_); }

  Step step(std::string_view& input, char*& to, std::size_t& room) override {
    constexpr std::size_t kMost = std::numeric_limits<uInt>::max();
    const auto available = static_cast<uInt>(std::min(input.size(), kMost));
    const auto wanted = static_cast<uInt>(std::min(room, kMost));
    state_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(input.data()));
    state_.avail_in = available;
    state_.next_out = reinterpret_cast<Bytef*>(to);
    state_.avail_out = wanted;
    const int code = ::inflate(&state_, Z_NO_FLUSH);
    input.remove_prefix(available - state_.avail_in);
    to += wanted - state_.avail_out;
    room -= wanted - state_.avail_out;
    if (code == Z_STREAM_END) return Step::kMemberEnds;
    return code == Z_OK || code == Z_BUF_ERROR ? Step::kMore : Step::kFault;
  }

  std::string fault() const override { return state_.msg != nullptr ? state_.msg : "invalid data"; }

 private:
  z_stream state_{};
};

class ZstdInflater : public Inflater {
 public:
  ZstdInflater() : state_(ZSTD_createDCtx()) {
    if (state_ == nullptr) throw std::bad_alloc();
  }
  ~ZstdInflater() override { ZSTD_freeDCtx(state_); }
  ZstdInflater(const ZstdInflater&) = delete;
  ZstdInflater& operator=(const ZstdInflater&) = delete;

  bool begins(std::string_view head) const override { return begins_zstd(head); }
  void reset() override { ZSTD_DCtx_reset(state_, ZSTD_reset_session_only); }

  Step step(std::string_view& input, char*& to, std::size_t& room) override {
    ZSTD_inBuffer in{input.data(), input.size(), 0};
    ZSTD_outBuffer out{to, room, 0};
    const std::size_t left = ZSTD_decompressStream(state_, &out, &in);
    input.remove_prefix(in.pos);
    to += out.pos;
    room -= out.pos;
    if (ZSTD_isError(left) != 0) {
      fault_ = ZSTD_getErrorName(left);
      return Step::kFault;
    }
    return left == 0 ? Step::kMemberEnds : Step::kMore;
  }

  std::string fault() const override { return fault_; }

 private:
  ZSTD_DCtx* state_;
  std::string fault_;
};

/// Throws std::bad_alloc where there is no memory for it. Null for kNone.
std::unique_ptr<Inflater> make_inflater(Compression compression) {
  if (compression == Compression::kGzip) return std::make_unique<GzipInflater>();
  if (compression == Compression::kZstd) return std::make_unique<ZstdInflater>();
  return nullptr;
}

}  // namespace

Compression compression_of(std::string_view head) {
  if (starts_with(head, kGzipMagic)) return Compression::kGzip;
  return begins_zstd(head) ? Compression::kZstd : Compression::kNone;
}

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
