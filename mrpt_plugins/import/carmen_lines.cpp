// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/detail/carmen_lines.h"

#include <bzlib.h>

#include <algorithm>
#include <new>
#include <string_view>

#include "libhybrid/core/error.h"
#include "libhybrid/io/regular_file.h"
#include "mrpt_plugins/rawlog/byte_io.h"
#include "mrpt_plugins/rawlog/decoder.h"

namespace hybrid {
namespace {

constexpr std::size_t kMostText = std::size_t{1} << 30;  // bytes of a compressed log in memory
constexpr std::string_view kBzip2Magic = "BZh";
const TextFormat kCarmenFormat{TextFormat::Cut::kWords, ""};

/// A compressed file as text; `step` appends some of it and returns whether there is more.
template <class Step>
std::string unpacked(const std::string& path, Step step) {
  std::string text;
  while (step(text)) {
    if (text.size() > kMostText) {
      throw Error(path + ": more than 1 GiB when decompressed: decompress it first");
    }
  }
  return text;
}

/// The streams of a bzip2 file, one after the other; pbzip2 makes several.
class Bzip2Streams {
 public:
  Bzip2Streams(const std::string& path, const std::string& bytes) : path_(path), rest_(bytes) {
    begin();
  }
  ~Bzip2Streams() { BZ2_bzDecompressEnd(&stream_); }
  Bzip2Streams(const Bzip2Streams&) = delete;
  Bzip2Streams& operator=(const Bzip2Streams&) = delete;

  /// Appends some of the text; returns whether there is more.
  bool step(std::string& text) {
    constexpr std::size_t kPortion = std::size_t{1} << 20;
    const std::size_t before = text.size(), given = std::min(rest_.size(), kPortion);
    text.resize(before + kPortion);
    stream_.next_in = const_cast<char*>(rest_.data());
    stream_.avail_in = static_cast<unsigned>(given);
    stream_.next_out = text.data() + before;
    stream_.avail_out = static_cast<unsigned>(kPortion);
    const int code = BZ2_bzDecompress(&stream_);
    rest_.remove_prefix(given - stream_.avail_in);
    text.resize(text.size() - stream_.avail_out);
    if (code == BZ_STREAM_END) return enter_next();
    const bool is_stuck = rest_.empty() && text.size() == before;
    if (code != BZ_OK || is_stuck) {
      throw Error(path_ + ": the bzip2 data is damaged or ends early; bzip2 -t tells more");
    }
    return true;
  }

 private:
  void begin() {
    if (BZ2_bzDecompressInit(&stream_, 0, 0) != BZ_OK) throw std::bad_alloc();
  }

  bool enter_next() {
    if (!starts_with(rest_, kBzip2Magic)) return false;
    BZ2_bzDecompressEnd(&stream_);
    stream_ = {};
    begin();
    return true;
  }

  const std::string& path_;
  std::string_view rest_;
  bz_stream stream_{};
};

std::string unpacked_by_decoder(const std::string& path, const std::string& bytes) {
  Decoder decoder(source_of(bytes));
  std::string text = unpacked(path, [&](std::string& all) {
    constexpr std::size_t kPortion = std::size_t{1} << 16;
    const std::size_t before = all.size();
    all.resize(before + kPortion);
    const std::size_t got = decoder.read(all.data() + before, kPortion);
    all.resize(before + got);
    return got > 0;
  });
  if (decoder.end() != DecodeEnd::kSound) throw Error(path + ": " + decoder.message());
  return text;
}

}  // namespace

CarmenLines::CarmenLines(const std::string& path) : path_(path) {
  RegularFile file(path);
  std::string head(4, '\0');
  head.resize(file.read(head.data(), head.size()));
  const bool is_bzip2 = starts_with(head, kBzip2Magic);
  if (!is_bzip2 && compression_of(head) == Compression::kNone) {
    rewind();
    return;
  }
  const std::string bytes = read_file(path, kMostText);
  if (is_bzip2) {
    Bzip2Streams streams(path, bytes);
    text_ = unpacked(path, [&](std::string& text) { return streams.step(text); });
  } else {
    text_ = unpacked_by_decoder(path, bytes);
  }
  rewind();
}

void CarmenLines::rewind() {
  reader_ = text_.empty() ? std::make_unique<TextReader>(path_, kCarmenFormat)
                          : std::make_unique<TextReader>(text_, path_, kCarmenFormat);
}

bool CarmenLines::is_cut() const {
  return text_.empty() ? ends_in_line(path_) : text_.back() != '\n';
}

}  // namespace hybrid
