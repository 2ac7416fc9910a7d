// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/detail/inflater.h"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <limits>
#include <new>

#include "mrpt_plugins/rawlog/byte_io.h"

namespace hybrid {
namespace {

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

}  // namespace

Compression compression_of(std::string_view head) {
  if (starts_with(head, kGzipMagic)) return Compression::kGzip;
  return begins_zstd(head) ? Compression::kZstd : Compression::kNone;
}

std::unique_ptr<Inflater> make_inflater(Compression compression) {
  if (compression == Compression::kGzip) return std::make_unique<GzipInflater>();
  if (compression == Compression::kZstd) return std::make_unique<ZstdInflater>();
  return nullptr;
}

}  // namespace hybrid
