// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <zlib.h>
#include <zstd.h>

#include <string>

#include "mrpt_plugins/rawlog/decoder.h"

namespace hybrid {

/// One gzip member with a right checksum.
inline std::string gzip(const std::string& bytes, int level = 6) {
  constexpr int kGzip = 16;
  z_stream stream{};
  deflateInit2(&stream, level, Z_DEFLATED, MAX_WBITS + kGzip, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

/// One Zstandard frame with a checksum.
inline std::string zstd(const std::string& bytes) {
  ZSTD_CCtx* context = ZSTD_createCCtx();
  ZSTD_CCtx_setParameter(context, ZSTD_c_checksumFlag, 1);
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  out.resize(ZSTD_compress2(context, out.data(), out.size(), bytes.data(), bytes.size()));
  ZSTD_freeCCtx(context);
  return out;
}

struct Decoded {
  std::string bytes;
  DecodeEnd end = DecodeEnd::kNone;
  std::string message;
  bool has_trailing_bytes = false;
};

/// All that can be decoded, in reads of `portion` bytes.
inline Decoded decode(const std::string& bytes, const InflationLimit& limit = {},
                      std::size_t portion = 1000) {
  Decoder decoder(source_of(bytes), limit);
  Decoded out;
  std::string part(portion, '\0');
  while (const std::size_t got = decoder.read(part.data(), part.size())) {
    out.bytes.append(part, 0, got);
  }
  out.end = decoder.end();
  out.message = decoder.message();
  out.has_trailing_bytes = decoder.has_trailing_bytes();
  return out;
}

}  // namespace hybrid
