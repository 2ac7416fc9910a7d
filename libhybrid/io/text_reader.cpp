// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/text_reader.h"

#include <algorithm>
#include <cstring>
#include <string_view>
#include <utility>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

constexpr std::pair<std::string_view, std::string_view> kMagic[] = {
    {"\x1f\x8b", "compressed with gzip: unpack it, or if it is a rawlog, use hybrid-replay"},
    {"\x28\xb5\x2f\xfd",
     "compressed with zstd: unpack it, or if it is a rawlog, use hybrid-replay"},
    {"\xfd"
     "7zXZ",
     "compressed with xz: unpack it"},
    {"BZh", "compressed with bzip2: unpack it"},
    {"PK\x03\x04", "a zip archive: unpack it"},
    {"\x89PNG", "a picture"},
    {"\xff\xd8\xff", "a picture"},
    {"%PDF-", "a PDF document"},
    {"\x7f"
     "ELF",
     "a program"},
};

/// MRPT's objects begin with the length of the name of their class, its highest bit set.
bool is_rawlog(std::string_view head) {
  if (head.empty() || (head[0] & 0x80) == 0) return false;
  const auto length = static_cast<std::size_t>(head[0] & 0x7f);
  constexpr std::size_t kLeast = 4;
  const std::string_view name = head.substr(1, length);
  const auto is_part = [](char c) {
    return c == ':' || c == '_' || (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') ||
           (c >= 'a' && c <= 'z');
  };
  return length >= kLeast && name.size() == length &&
         std::all_of(name.begin(), name.end(), is_part);
}

/// The kind of a binary file by its first bytes, and what to do with it, as the end of the sentence
/// "this file is ..."; empty for text and unknown kinds.
std::string_view binary_kind(std::string_view head) {
  for (const auto& [magic, kind] : kMagic) {
    if (head.substr(0, magic.size()) == magic) return kind;
  }
  return is_rawlog(head) ? "a rawlog: use hybrid-replay" : "";
}

constexpr std::size_t kChunk = std::size_t{1} << 18;

/// The position of the first of some characters, or npos.
std::size_t find_any(std::string_view text, std::string_view characters) {
  std::size_t at = std::string_view::npos;
  for (const char c : characters) at = std::min(at, text.substr(0, at).find(c));
  return at;
}

}  // namespace

TextReader::TextReader(const std::string& path, const TextFormat& format)
    : name_(std::make_shared<std::string>(path)),
      format_(format),
      file_(std::make_unique<RegularFile>(path)) {
  check_size(path, file_->size(), kLargestText);
  fill();
  check_encoding();
}

TextReader::TextReader(std::string_view text, const std::string& name, const TextFormat& format)
    : name_(std::make_shared<std::string>(name)), format_(format), rest_(text) {
  check_encoding();
}

void TextReader::check_encoding() {
  constexpr std::string_view kUtf8 = "\xef\xbb\xbf";
  if (rest_.substr(0, kUtf8.size()) == kUtf8) rest_.remove_prefix(kUtf8.size());
  const std::string_view mark = rest_.substr(0, 2);
  if (mark == "\xff\xfe" || mark == "\xfe\xff") {
    throw Error(*name_ + ":1:1: text in UTF-16; save it as UTF-8");
  }
  const std::string_view kind = binary_kind(rest_);
  if (!kind.empty()) throw Error(*name_ + ": not text, but " + std::string(kind));
}

bool TextReader::fill() {
  if (!file_) return false;
  if (rest_.data() != buffer_.data()) {
    buffer_.erase(0, buffer_.size() - rest_.size());
  }
  const std::size_t size = buffer_.size();
  buffer_.resize(size + kChunk);
  const std::size_t got = file_->read(buffer_.data() + size, kChunk);
  buffer_.resize(size + got);
  rest_ = buffer_;
  bytes_ += got;
  check_size(*name_, bytes_, kLargestText);
  return got > 0;
}

bool TextReader::next_line(std::string_view& line) {
  std::size_t end = rest_.find('\n');
  while (end == std::string_view::npos && rest_.size() <= kLongestLine) {
    const std::size_t searched = rest_.size();
    if (!fill()) break;
    end = rest_.find('\n', searched);
  }
  if (rest_.empty()) return false;
  ++line_;
  line = rest_.substr(0, end);
  rest_.remove_prefix(std::min(rest_.size(), line.size() + 1));
  last_ = line;
  if (line.size() > kLongestLine) {
    throw Error(at_place(*name_, line_, "", 0,
                         "a line of more than " + std::to_string(kLongestLine) + " bytes"));
  }
  const std::size_t nul = line.find('\0');
  if (nul != std::string_view::npos) {
    throw Error(at_place(*name_, line_, line, nul, "a NUL byte: this is not text in UTF-8"));
  }
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  last_ = line;
  return true;
}

bool TextReader::next(TextRow& row) {
  std::string_view line;
  while (next_line(line)) {
    const std::size_t mark = find_any(line, format_.comments);
    if (mark != std::string_view::npos && on_comment) on_comment(line.substr(mark + 1));
    row.text_.assign(line.substr(0, mark));
    format_.cut == TextFormat::Cut::kWords ? row.cut_words() : row.cut_cells();
    if (row.size() == 0) continue;
    if (row.file_ != name_) row.file_ = name_;
    row.line_ = line_;
    return has_rows_ = true;
  }
  return false;
}

std::optional<TextRow> TextReader::next() {
  TextRow row;
  if (next(row)) return row;
  if (!has_rows_) throw Error(*name_ + ": holds no row");
  return std::nullopt;
}

std::optional<TextRow> TextReader::first_below(std::string_view title) {
  std::optional<TextRow> row = next();
  return row && (*row)[0] == title ? next() : row;
}

bool TextReader::read_bytes(char* to, std::size_t count) {
  last_ = {};
  while (rest_.size() < count) {
    if (!fill()) return false;
  }
  std::memcpy(to, rest_.data(), count);
  rest_.remove_prefix(count);
  return true;
}

bool TextReader::skip_bytes(std::uint64_t count) {
  last_ = {};
  while (rest_.size() < count) {
    count -= rest_.size();
    rest_ = {};
    if (!fill()) return count == 0;
  }
  rest_.remove_prefix(static_cast<std::size_t>(count));
  return true;
}

double TextReader::share() const {
  if (!file_ || file_->size() == 0) return 1;
  return std::min(1.0,
                  static_cast<double>(bytes_ - rest_.size()) / static_cast<double>(file_->size()));
}

void TextReader::fail(const std::string& what) const {
  throw Error(at_place(*name_, line_, last_, last_.size(), what));
}

}  // namespace hybrid
