// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Puts up to `count` bytes of a file at `to` and returns how many; 0 at its end.
using ByteSource = std::function<std::size_t(char* to, std::size_t count)>;

/// A source that gives these bytes, which must outlive it.
ByteSource source_of(std::string_view bytes);

enum class Compression { kNone, kGzip, kZstd };

/// What a file that begins with these bytes is compressed with.
Compression compression_of(std::string_view head);

/// Up to where compressed bytes may grow: `free_bytes`, and `ratio` times what was read of them.
/// MRPT's sample logs grow 1.4 to 33 times, one that repeats a single byte 1000 times by gzip and
/// 10,000 times by Zstandard.
struct InflationLimit {
  std::uint64_t free_bytes = std::uint64_t{32} << 20;
  std::uint64_t ratio = 100;
};

/// Why the decoded bytes end where they do.
enum class DecodeEnd {
  kNone,       ///< They go on.
  kSound,      ///< The file is at its end, checksums agree. A plain file has none.
  kTruncated,  ///< The file ends inside of the compressed bytes.
  kDamaged,    ///< The compressed bytes are wrong.
  kTooLarge,   ///< They grow beyond the limit.
};

/// One step of a compression method.
class Inflater;

/// The bytes of a plain, gzip or Zstandard file in one pass and in bounded memory, up to the first
/// fault: what can be decoded before it is given. Files of several members one after the other, as
/// `cat a.gz b.gz` makes them, are one stream; bytes behind the last member that begin no other are
/// left out, as gzip does.
class Decoder {
 public:
  explicit Decoder(ByteSource source, const InflationLimit& limit = {});
  ~Decoder();
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;

  /// Puts up to `count` decoded bytes at `to` as soon as there are any; none only at the end.
  std::size_t read(char* to, std::size_t count);

  Compression compression() const { return compression_; }
  DecodeEnd end() const { return end_; }
  /// One line about an end that is not sound.
  const std::string& message() const { return message_; }
  /// Whether the file goes on behind its last member with something else.
  bool has_trailing_bytes() const { return has_trailing_bytes_; }

 private:
  void load();
  std::size_t copy(char* to, std::size_t count);
  std::size_t inflate(char* to, std::size_t count);
  bool enter_member();
  void finish(DecodeEnd end, const std::string& message = "");

  ByteSource source_;
  InflationLimit limit_;
  std::unique_ptr<char[]> buffer_;
  std::string_view input_;  // part of the buffer that is not used yet
  bool at_end_ = false;     // of the source
  Compression compression_ = Compression::kNone;
  std::unique_ptr<Inflater> inflater_;
  bool in_member_ = false;
  bool holds_more_ = false;             // the inflater may, without more input
  std::uint64_t read_ = 0, given_ = 0;  // bytes in and out
  DecodeEnd end_ = DecodeEnd::kNone;
  std::string message_;
  bool has_trailing_bytes_ = false;
};

/// Why a file cannot be decoded to its end, however large that is; empty if it can. Throws Error as
/// RegularFile does.
std::string decoding_fault(const std::string& path);

}  // namespace hybrid
