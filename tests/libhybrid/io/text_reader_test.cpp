// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/text_reader.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <functional>
#include <string>
#include <vector>

#include "libhybrid/core/error.h"
#include "libhybrid/io/escaped.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

constexpr TextFormat kWords{TextFormat::Cut::kWords, "#"};

std::string message_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

/// The words of all rows of a text.
std::vector<std::vector<std::string>> rows_of(std::string_view text,
                                              const TextFormat& format = {}) {
  std::vector<std::vector<std::string>> rows;
  TextReader reader(text, "f", format);
  TextRow row;
  while (reader.next(row)) {
    rows.emplace_back();
    for (std::size_t i = 0; i < row.size(); ++i) rows.back().emplace_back(row[i]);
  }
  return rows;
}

/// The message of a check of the first row of a text.
std::string error_in(std::string_view text, const std::function<void(const TextRow&)>& check,
                     const TextFormat& format = {}) {
  return message_of([&] {
    TextReader reader(text, "f", format);
    check(*reader.next());
  });
}

using Rows = std::vector<std::vector<std::string>>;

class TextFiles : public ScratchFolder {};

TEST(TextReader, CutsLinesWhateverTheirEndsAreAndSkipsMarksOfTheEncoding) {
  const Rows expected = {{"1", "2"}, {"3"}};
  EXPECT_EQ(rows_of("1 2\n3\n"), expected);
  EXPECT_EQ(rows_of("\xef\xbb\xbf"
                    "1 2\r\n\r\n  3 "),
            expected);
  EXPECT_EQ(rows_of("# c\n1\t2 % c\n\n3"), expected);
  EXPECT_EQ(rows_of(""), Rows{});
  EXPECT_EQ(rows_of("\n \n#\n"), Rows{});
}

TEST(TextReader, CutsCellsAtTheOneSeparatorOfALine) {
  EXPECT_EQ(rows_of("a, b b ,,c\n"), (Rows{{"a", "b b", "", "c"}}));
  EXPECT_EQ(rows_of("1,5; 2\n"), (Rows{{"1,5", "2"}}));
  EXPECT_EQ(rows_of(",\n"), (Rows{{"", ""}}));
  EXPECT_EQ(rows_of("1,5; 2\n", kWords), (Rows{{"1,5;", "2"}}));
}

TEST(TextReader, NamesTheColumnOfCharactersAndWhatIsWrong) {
  const auto number = [](std::size_t i) { return [i](const TextRow& row) { row.number(i); }; };
  EXPECT_EQ(error_in("\n  1 x", number(1)), "f:2:5: 'x' is not a number");
  EXPECT_EQ(error_in("\xc3\xa9 x", number(1)), "f:1:3: 'x' is not a number");
  EXPECT_EQ(error_in("\xef\xbb\xbfx", number(0)), "f:1:1: 'x' is not a number");
  for (const char* word : {"nan", "inf", "-inf", "1e400", "1e-400", "+infinity"}) {
    EXPECT_EQ(error_in(word, number(0)),
              "f:1:1: '" + std::string(word) + "' is not a finite number");
  }
  for (const char* word : {"0x10", "1e", "1.5x", "--1", "+-1", "\xef\xbc\x91", "1_000"}) {
    EXPECT_EQ(error_in(word, number(0)), "f:1:1: '" + std::string(word) + "' is not a number");
  }
  EXPECT_EQ(error_in("1,,2", number(1)), "f:1:3: an empty column; expected a number");
  EXPECT_EQ(error_in("+5 -.5e-3", number(1)), "no error");
}

TEST(TextReader, NamesDecimalCommasAndSemicolons) {
  const auto number = [](const TextRow& row) { row.number(0), row.number(1); };
  const std::string comma = "decimals are written with a point";
  EXPECT_EQ(error_in("1,5 2", number, kWords), "f:1:1: '1,5' is not a number; " + comma);
  EXPECT_EQ(error_in("1,5; 2", number), "f:1:1: '1,5' is not a number; " + comma);
  EXPECT_NE(error_in("1,5 2,5 3,5", number).find("'5 2' is not a number; columns are separated by"),
            std::string::npos);
  EXPECT_EQ(error_in("1;2 3", number, kWords),
            "f:1:1: '1;2' is not a number; columns are separated by blanks");
  const auto three = [](const TextRow& row) { row.expect(3, "x y z"); };
  EXPECT_NE(error_in("1,5 2,5 3,5", three).find(comma), std::string::npos);
}

TEST(TextReader, CountsColumns) {
  const auto two = [](const TextRow& row) { row.expect(2, "a b"); };
  EXPECT_EQ(error_in("1", two), "f:1:2: 1 column; expected: a b");
  EXPECT_EQ(error_in("1 2 3", two), "f:1:5: 3 columns; expected: a b");
  EXPECT_EQ(error_in("1 2", two), "no error");
  TextReader reader("1 2 3\n1 2 3\n1 2 3 4\n", "f", TextFormat());
  std::size_t columns = 0;
  reader.next()->expect_same(columns, 2, "a b ...");
  reader.next()->expect_same(columns, 2, "a b ...");
  EXPECT_EQ(message_of([&] { reader.next()->expect_same(columns, 2, "a b ..."); }),
            "f:3:7: 4 columns; expected: a b ... (3 as in the first row)");
}

TEST(TextReader, BoundsCoordinatesTimesAndIds) {
  EXPECT_EQ(error_in("-1e15", [](const TextRow& row) { row.coordinate(0); }), "no error");
  EXPECT_NE(error_in("1e16", [](const TextRow& row) { row.coordinate(0); }).find("beyond 1e15"),
            std::string::npos);
  EXPECT_NE(error_in("1403636579758555392", [](const TextRow& row) { row.time(0); })
                .find("not a time in seconds: it is beyond 1e11; are these nanoseconds?"),
            std::string::npos);
  EXPECT_NE(error_in("1403636579758", [](const TextRow& row) { row.time(0); })
                .find("beyond 1e11; are these milliseconds?"),
            std::string::npos);
  const auto id = [](const TextRow& row) { return row.id(0); };
  EXPECT_EQ(TextReader("5.0", "f", kWords).next()->id(0), 5);
  EXPECT_EQ(TextReader("2147483647", "f", kWords).next()->id(0), 2147483647);
  EXPECT_EQ(error_in("2147483648", id), "f:1:1: '2147483648' is larger than 2147483647");
  EXPECT_EQ(error_in("1e300", id), "f:1:1: '1e300' is larger than 2147483647");
  EXPECT_EQ(error_in("18446744073709551616", id),
            "f:1:1: '18446744073709551616' is larger than 2147483647");
  for (const char* word : {"-1", "1.5"}) {
    EXPECT_NE(error_in(word, id).find("is not a whole number of at least 0"), std::string::npos);
  }
}

TEST(TextReader, TimesOfIso8601AreSecondsSince1970) {
  const auto time = [](const char* text) {
    return TextReader(text, "f", TextFormat()).next()->time(0);
  };
  // date -u -d 2024-05-01T12:00:00.25 +%s.%N
  EXPECT_DOUBLE_EQ(time("2024-05-01T12:00:00.25,1"), 1714564800.25);
  EXPECT_DOUBLE_EQ(time("2024-05-01 12:00:00.25Z,1"), 1714564800.25);
  EXPECT_DOUBLE_EQ(time("2024-05-01T14:30:00.25+02:30,1"), 1714564800.25);
  EXPECT_DOUBLE_EQ(time("2024-05-01T05:00:00-07:00,1"), 1714564800);
  EXPECT_DOUBLE_EQ(time("2024-02-29T23:59:59.5,1"), 1709251199.5);
  EXPECT_DOUBLE_EQ(time("2000-12-31T00:00:00,1"), 978220800);
  EXPECT_DOUBLE_EQ(time("1969-12-31T23:59:59,1"), -1);
  for (const char* word : {"2023-02-29T00:00:00", "2024-13-01T00:00:00", "2024-05-01T12:00:99",
                           "2024-05-01T12:00:00x", "2024-05-01T24:00:00", "2024-05-00T12:00:00",
                           "2024-05-01T12:00:00+0", "2024-+5-01T12:00:00", "12:00:05"}) {
    EXPECT_EQ(error_in(word, [](const TextRow& row) { row.time(0); }),
              std::string("f:1:1: '") + word +
                  "' is not a time in seconds, or as 2024-05-01T12:00:00.25");
  }
}

TEST(TextReader, RefusesWhatIsNoText) {
  const auto read = [](const std::string& text) { return message_of([&] { rows_of(text); }); };
  EXPECT_EQ(read(std::string("1 2\n1 \0 2\n", 10)), "f:2:3: a NUL byte: this is not text in UTF-8");
  EXPECT_EQ(read(std::string("\xff\xfe"
                             "1\0",
                             4)),
            "f:1:1: text in UTF-16; save it as UTF-8");
  EXPECT_EQ(read(std::string("\xfe\xff\0"
                             "1",
                             4)),
            "f:1:1: text in UTF-16; save it as UTF-8");
  EXPECT_NE(read("\x1f\x8b\x08").find("compressed with gzip"), std::string::npos);
  EXPECT_EQ(read("\x98mrpt::obs::CSensoryFrame\x02"),
            "f: not text, but a rawlog: use hybrid-replay");
  const std::string longest(TextReader::kLongestLine, '1');
  EXPECT_EQ(read(longest + "\n"), "no error");
  EXPECT_EQ(read("\n" + longest + "1"), "f:2:1: a line of more than 1048576 bytes");
}

TEST(TextReader, MessagesEscapeWhatATerminalWouldObey) {
  EXPECT_EQ(in_quotes("a\x1b[31mb\x07"), "'a\\x1b[31mb\\x07'");
  EXPECT_EQ(in_quotes("\xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80"),
            "'\xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80'");
  EXPECT_EQ(in_quotes("\xff\xc3"), "'\\xff\\xc3'");
  EXPECT_EQ(in_quotes("\xc0\xaf\xed\xa0\x80"),
            "'\\xc0\\xaf\\xed\\xa0\\x80'");  // overlong; surrogate
  EXPECT_EQ(in_quotes("\xe2\x80\xae"
                      "a"),
            "'\\xe2\\x80\\xae"
            "a'");  // turns the direction of text
  EXPECT_EQ(in_quotes(std::string(41, 'x')), "'" + std::string(40, 'x') + "...'");
  EXPECT_EQ(in_quotes(std::string(40, 'x')), "'" + std::string(40, 'x') + "'");
}

TEST_F(TextFiles, AreReadInPiecesAsIfTheyWereText) {
  std::string text;
  for (int i = 0; i < 200000; ++i) text += std::to_string(i) + (i % 7 == 0 ? " # c\n" : "\n");
  TextReader reader(write("long.txt", text));
  TextRow row;
  int count = 0;
  for (; reader.next(row); ++count) {
    ASSERT_EQ(row.size(), 1u);
    ASSERT_EQ(row.id(0), count);
    ASSERT_EQ(row.line(), static_cast<std::size_t>(count) + 1);
  }
  EXPECT_EQ(count, 200000);
}

TEST_F(TextFiles, HoldBinaryDataBehindLines) {
  std::string bytes;
  for (int i = 0; i < 1000000; ++i) bytes += static_cast<char>(i % 251);
  TextReader reader(write("b", "head\n" + bytes), kWords);
  ASSERT_TRUE(reader.next());
  char got[3] = {};
  ASSERT_TRUE(reader.read_bytes(got, 3));
  EXPECT_EQ(got[2], 2);
  ASSERT_TRUE(reader.skip_bytes(900000));
  ASSERT_TRUE(reader.read_bytes(got, 1));
  EXPECT_EQ(static_cast<unsigned char>(got[0]), 900003 % 251);
  EXPECT_FALSE(reader.skip_bytes(100000));
  EXPECT_FALSE(reader.read_bytes(got, 1));
}

// The same message everywhere; nothing waits for the other end of a pipe.
TEST_F(TextFiles, MustBeRegularFiles) {
  const auto open = [](const std::string& path) {
    return message_of([&] { TextReader reader(path); });
  };
  const std::string pipe = at("pipe");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(open(pipe), pipe + ": is a pipe, not a regular file");
  EXPECT_EQ(open(folder.string()), folder.string() + ": is a folder, not a file");
  EXPECT_EQ(open("/dev/zero"), "/dev/zero: is a device, not a regular file");
  EXPECT_EQ(open(at("none")), at("none") + ": no such file");
  EXPECT_EQ(open(write("file", "1") + "/x"), at("file") + "/x: no such file");
  EXPECT_EQ(open(""), ": no such file");
  if (::geteuid() != 0) {
    ::chmod(write("closed", "1").c_str(), 0);
    EXPECT_EQ(open(at("closed")), at("closed") + ": cannot be read: Permission denied");
  }
}

// A file of 100 GB without content is refused by its size; one without a line end after 1 MiB.
TEST_F(TextFiles, AreOfBoundedSize) {
  const std::string huge = write("huge", "1\n");
  ASSERT_EQ(::truncate(huge.c_str(), off_t{100} << 30), 0);
  const std::string what = huge + ": is larger than 4 GiB, the most that is read";
  EXPECT_EQ(message_of([&] { TextReader reader(huge); }), what);
  EXPECT_EQ(message_of([&] { read_file(huge); }), what);
  ASSERT_EQ(::truncate(huge.c_str(), off_t{1} << 31), 0);
  TextReader reader(huge);
  TextRow row;
  ASSERT_TRUE(reader.next(row));
  EXPECT_EQ(message_of([&] { reader.next(row); }),
            huge + ":2:1: a line of more than 1048576 bytes");
  EXPECT_EQ(message_of([&] { read_file(huge, 5000); }),
            huge + ": is larger than 5000 bytes, the most that is read");
  EXPECT_EQ(read_file(write("small", "abc"), 3), "abc");
  EXPECT_EQ(read_file(write("empty", "")), "");
}

TEST_F(TextFiles, TellHowMuchOfThemIsRead) {
  TextReader reader(write("a", "123\n\n5678\n"));
  EXPECT_EQ(reader.share(), 0);
  reader.next();
  EXPECT_EQ(reader.share(), 0.4);
  reader.next();
  EXPECT_EQ(reader.share(), 1);
  EXPECT_EQ(TextReader("1\n2\n", "text", {}).share(), 1);
}

TEST_F(TextFiles, TellWhetherTheyEndWithinALine) {
  EXPECT_TRUE(ends_in_line(write("a", "1\n2")));
  EXPECT_FALSE(ends_in_line(write("a", "1\n2\n")));
  EXPECT_FALSE(ends_in_line(write("a", "")));
}

TEST_F(TextFiles, SayWhenTheyHoldNoRow) {
  const auto read = [](const std::string& path) {
    return message_of([&] {
      TextReader reader(path);
      while (reader.next()) {
      }
    });
  };
  EXPECT_EQ(read(write("a", "# 1\n\n")), at("a") + ": holds no row");
  EXPECT_EQ(read(write("a", "1\n")), "no error");
}

}  // namespace
}  // namespace hybrid
