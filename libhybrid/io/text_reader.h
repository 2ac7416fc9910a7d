// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "libhybrid/io/regular_file.h"
#include "libhybrid/io/text_row.h"

namespace HYBRID_API hybrid {

/// How the lines of a text are cut.
struct TextFormat {
  /// kWords: words between blanks. kCells: columns between semicolons if the line has any, else
  /// between commas if it has any, else between blanks; columns may be empty, and blanks around
  /// them are no part of them.
  enum class Cut { kWords, kCells };
  Cut cut = Cut::kCells;
  std::string_view comments = "%#";  ///< characters that begin a comment, up to the end of the line
};

/// Reads text line by line, in bounded memory however large the file: UTF-8 or any other encoding
/// that agrees with ASCII, with or without a byte order mark; lines end with LF or CRLF, the last
/// one also with the file. Throws Error "file:line:column: what" for a NUL byte, a line of more
/// than 1 MiB and text in UTF-16, and Error "file: what" as RegularFile and for more than
/// kLargestText bytes.
class TextReader {
 public:
  static constexpr std::size_t kLongestLine = std::size_t{1} << 20;

  /// Reads a file.
  explicit TextReader(const std::string& path, const TextFormat& format = {});
  /// Reads text, which must outlive the reader; `name` is the name of the file in messages.
  TextReader(std::string_view text, const std::string& name, const TextFormat& format);
  TextReader(const TextReader&) = delete;
  TextReader& operator=(const TextReader&) = delete;

  const std::string& name() const { return *name_; }
  /// Number of lines read so far.
  std::size_t line() const { return line_; }
  /// Share of the file that has been returned, 0 to 1; 1 for text and where the size is unknown.
  double share() const;

  /// The next line that holds more than blanks and comments; false at the end.
  bool next(TextRow& row);
  /// The same as a value, empty at the end; throws Error if the file ends without any row.
  std::optional<TextRow> next();
  /// The first row that is not one of titles, of which the first is `title`; throws as next().
  std::optional<TextRow> first_below(std::string_view title);
  /// The next line without its end; it stays valid until the next call. False at the end.
  bool next_line(std::string_view& line);
  /// Reads, or skips, binary data after the lines read; false if there are fewer than `count`
  /// bytes.
  bool read_bytes(char* to, std::size_t count);
  bool skip_bytes(std::uint64_t count);

  /// Called with the text of every comment.
  std::function<void(std::string_view)> on_comment;

  /// Throws Error "file:line:column: what", for the end of the last line read.
  [[noreturn]] void fail(const std::string& what) const;

 private:
  bool fill();
  void check_encoding();

  std::shared_ptr<const std::string> name_;
  TextFormat format_;
  std::unique_ptr<RegularFile> file_;  // null for text
  std::string buffer_;
  std::string_view rest_;  // read and not yet returned
  std::string_view last_;  // the line returned last
  std::uint64_t bytes_ = 0;
  std::size_t line_ = 0;
  bool has_rows_ = false;
};

}  // namespace hybrid
