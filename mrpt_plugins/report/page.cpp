// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/report/page.h"

#include <nettle/base64.h>
#include <zlib.h>

#include <cstdint>
#include <nlohmann/json.hpp>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

constexpr std::string_view kPlace = "<!-- data -->";  // of the data in the template
constexpr int kGzip = 15 + 16;                        // window of 2^15 bytes, with gzip's header
constexpr int kMemory = 8;                            // zlib's default

std::string gzipped(const std::string& text) {
  z_stream stream{};
  if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, kGzip, kMemory, Z_DEFAULT_STRATEGY) !=
      Z_OK) {
    throw Error("the report cannot be compressed: memory is short");
  }
  std::string out(deflateBound(&stream, text.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const int status = deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  if (status != Z_STREAM_END) throw Error("the report cannot be compressed: it is too large");
  return out;
}

}  // namespace

std::string base64(const std::string& bytes) {
  std::string out(BASE64_ENCODE_RAW_LENGTH(bytes.size()), '\0');
  base64_encode_raw(out.data(), bytes.size(), reinterpret_cast<const std::uint8_t*>(bytes.data()));
  return out;
}

std::string report_page(const nlohmann::ordered_json& data) {
  const std::string text = data.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  const std::string_view page = report_template();
  const std::size_t at = page.find(kPlace);
  std::string out(page.substr(0, at));
  out += base64(gzipped(text));
  out += page.substr(at + kPlace.size());
  return out;
}

}  // namespace hybrid
