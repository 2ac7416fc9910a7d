// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/read_points.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>

#include "libhybrid/core/error.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

class ReadPoints : public ScratchFolder {
 protected:
  /// The message of the error, or "" if there is none.
  std::string error(const std::string& name, const std::string& content) {
    try {
      read_points(write(name, content));
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  }
  static bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  }
};

const Points kExpected = {{1, 2, 3}, {-4.5, 5e-1, 6}};

TEST_F(ReadPoints, RowsWithCommentsColumnsAndSeparators) {
  const std::string rows = "# x y z\n1 2 3\n\n-4.5, 5e-1,+6 \r\n";
  EXPECT_EQ(read_points(write("a.xyz", rows)).points, kExpected);
  EXPECT_EQ(read_points(write("a.CSV", rows)).points, kExpected);
}

TEST_F(ReadPoints, PlyText) {
  const std::string ply =
      "ply\nformat ascii 1.0\ncomment made by hand\nelement camera 1\nproperty float f\n"
      "element vertex 2\nproperty uchar red\nproperty float x\nproperty float y\n"
      "property double z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "0.5\n7 1 2 3\n8 -4.5 0.5 6\n3 0 1 0\n";
  EXPECT_EQ(read_points(write("a.ply", ply)).points, kExpected);
}

template <class T>
std::string bytes(T value, bool swap) {
  std::string text(sizeof(T), '\0');
  std::memcpy(text.data(), &value, sizeof(T));
  return swap ? std::string(text.rbegin(), text.rend()) : text;
}

TEST_F(ReadPoints, PlyBinaryOfBothOrders) {
  for (const bool big : {false, true}) {
    std::string ply = std::string("ply\nformat binary_") + (big ? "big" : "little") +
                      "_endian 1.0\nelement strip 1\nproperty list uchar short i\n"
                      "element vertex 2\nproperty short intensity\nproperty float x\n"
                      "property float y\nproperty double z\nend_header\n";
    ply += bytes<unsigned char>(2, big) + bytes<short>(1, big) + bytes<short>(2, big);
    for (const Eigen::Vector3d& p : kExpected) {
      ply += bytes<short>(-3, big) + bytes(float(p.x()), big) + bytes(float(p.y()), big) +
             bytes(p.z(), big);
    }
    EXPECT_EQ(read_points(write("b.ply", ply)).points, kExpected);
    EXPECT_TRUE(has(error("c.ply", ply.substr(0, ply.size() - 3)), "the file ends after 1"));
  }
}

TEST_F(ReadPoints, PcdText) {
  const std::string pcd =
      "# .PCD v0.7\nVERSION 0.7\nFIELDS rgb normal x y z\nSIZE 4 4 4 4 4\nTYPE F F F F F\n"
      "COUNT 1 2 1 1 1\nWIDTH 3\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ascii\n"
      "0 8 9 1 2 3\n0 8 9 nan nan nan\n0 8 9 -4.5 0.5 6\n";
  const PointFile read = read_points(write("a.pcd", pcd));
  EXPECT_EQ(read.points, kExpected);
  EXPECT_EQ(read.left_out, 1u);
}

const std::string kPcdFields =
    "VERSION 0.7\nFIELDS ring x y z\nSIZE 2 4 4 8\nTYPE U F F F\nCOUNT 2 1 1 1\nWIDTH 2\nHEIGHT "
    "1\n";

TEST_F(ReadPoints, PcdBinary) {
  std::string pcd = kPcdFields + "DATA binary\n";
  for (const Eigen::Vector3d& p : kExpected) {
    pcd += bytes<short>(1, false) + bytes<short>(2, false) + bytes(float(p.x()), false) +
           bytes(float(p.y()), false) + bytes(p.z(), false);
  }
  EXPECT_EQ(read_points(write("b.pcd", pcd)).points, kExpected);
  EXPECT_TRUE(has(error("c.pcd", pcd.substr(0, pcd.size() - 3)), "the file ends after 1"));
}

/// Blocks of LZF that copy nothing.
std::string literals(const std::string& raw) {
  std::string out;
  for (std::size_t at = 0; at < raw.size(); at += 32) {
    const std::string part = raw.substr(at, 32);
    out += static_cast<char>(part.size() - 1);
    out += part;
  }
  return out;
}

TEST_F(ReadPoints, PcdCompressed) {
  // Eight bytes of rings, of which the second half copies the first, then all x, all y, all z.
  std::string raw;
  for (const Eigen::Vector3d& p : kExpected) raw += bytes(float(p.x()), false);
  for (const Eigen::Vector3d& p : kExpected) raw += bytes(float(p.y()), false);
  for (const Eigen::Vector3d& p : kExpected) raw += bytes(p.z(), false);
  const std::string rings = literals("ring") + std::string("\x40\x03", 2);
  const auto file = [&](const std::string& packed, std::uint32_t size) {
    return kPcdFields + "DATA binary_compressed\n" +
           bytes(static_cast<std::uint32_t>(packed.size()), false) + bytes(size, false) + packed;
  };
  const std::string packed = rings + literals(raw);
  EXPECT_EQ(read_points(write("a.pcd", file(packed, 40))).points, kExpected);
  EXPECT_TRUE(has(error("b.pcd", file(packed, 41)), "does not have the size that it states"));
  EXPECT_TRUE(has(error("b.pcd", file(packed, 0xffffffff)), "does not have the size"));
  EXPECT_TRUE(has(error("b.pcd", file(literals(raw), 32)), "2 points of 20 bytes"));
  EXPECT_TRUE(has(error("b.pcd", file("\x40\x03" + packed, 40)), "data is damaged"));
  EXPECT_TRUE(has(error("b.pcd", file(packed.substr(0, 20), 40)), "data is damaged"));
  const std::string whole = file(packed, 40);
  EXPECT_TRUE(has(error("b.pcd", whole.substr(0, whole.size() - 1)), "ends early"));
}

// Floating ones are seconds, whole ones nanoseconds, and those of points that are left out are too.
TEST_F(ReadPoints, TimesOfPoints) {
  const auto pcd = [](const std::string& name, const std::string& type) {
    return "FIELDS x y z " + name + "\nSIZE 4 4 4 8\nTYPE F F F " + type +
           "\nCOUNT 1 1 1 1\nWIDTH 3\nHEIGHT 1\nDATA ascii\n1 2 3 nan\nnan 2 3 4\n1 2 3 5e9\n";
  };
  for (const char* name : {"t", "time", "timestamp", "offset_time"}) {
    const PointFile seconds = read_points(write("a.pcd", pcd(name, "F")));
    ASSERT_EQ(seconds.times.size(), 2U) << name;
    EXPECT_TRUE(std::isnan(seconds.times[0]));
    EXPECT_EQ(seconds.times[1], 5e9);
    EXPECT_NEAR(read_points(write("a.pcd", pcd(name, "U"))).times.at(1), 5, 1e-12);
  }
  EXPECT_TRUE(read_points(write("a.pcd", pcd("intensity", "F"))).times.empty());
  EXPECT_TRUE(read_points(write("a.pcd", pcd("t", "X"))).times.empty());
  EXPECT_TRUE(has(error("b.pcd", pcd("t", "F") + "1 2 3 4\n"), "but more follow"));
  std::string text = pcd("t", "F");
  text.replace(text.find("nan\n"), 3, "now");
  EXPECT_TRUE(has(error("b.pcd", text), "'now' is not a number"));
  std::string raw;
  for (const Eigen::Vector3d& p : kExpected) raw += bytes(float(p.x()), false);
  for (const Eigen::Vector3d& p : kExpected) raw += bytes(float(p.y()), false);
  for (const Eigen::Vector3d& p : kExpected) raw += bytes(float(p.z()), false);
  raw += bytes(std::int32_t{-1000}, false) + bytes(std::int32_t{2000}, false);
  const PointFile packed =
      read_points(write("c.pcd",
                        "FIELDS x y z t\nSIZE 4 4 4 4\nTYPE F F F I\nWIDTH 2\nDATA "
                        "binary_compressed\n" +
                            bytes(static_cast<std::uint32_t>(literals(raw).size()), false) +
                            bytes(static_cast<std::uint32_t>(raw.size()), false) + literals(raw)));
  EXPECT_EQ(packed.points, kExpected);
  EXPECT_NEAR(packed.times.at(0), -1e-6, 1e-15);
  EXPECT_NEAR(packed.times.at(1), 2e-6, 1e-15);
}

TEST_F(ReadPoints, CloudsMayBeEmpty) {
  EXPECT_TRUE(read_cloud(write("a.xyz", "")).points.empty());
  EXPECT_EQ(read_cloud(write("a.xyz", "nan 1 2\n")).left_out, 1U);
}

TEST_F(ReadPoints, SaysWhatIsWrongAndWhere) {
  EXPECT_TRUE(has(error("a.obj", "1 2 3\n"), "unknown kind of point cloud"));
  EXPECT_TRUE(has(error("a.xyz", ""), "holds no point"));
  EXPECT_TRUE(has(error("a.xyz", "nan 1 2\n"), "none of its points is finite"));
  EXPECT_TRUE(has(error("a.xyz", "1 2\n"), "a.xyz:1:4: 2 columns; expected: x y z"));
  EXPECT_TRUE(has(error("a.xyz", "1 2 3\n\n1 two 3\n"), "a.xyz:3:3: 'two' is not a number"));
  EXPECT_TRUE(has(error("a.ply", "solid\n"), "does not begin with 'ply'"));
  EXPECT_TRUE(has(error("a.ply",
                        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                        "property float y\nend_header\n1 2\n"),
                  "no property 'z'"));
  EXPECT_TRUE(has(error("a.ply",
                        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n"
                        "property float y\nproperty float z\nend_header\n1 2 3\n"),
                  "the header says 2 of element 'vertex', the file ends after 1"));
  EXPECT_TRUE(has(error("a.ply", "ply\nformat ascii 1.0\n"), "ends inside the header"));
  EXPECT_TRUE(has(error("a.ply", "ply\nformat ascii 1.0\nelement face 1\nend_header\n1\n"),
                  "no element 'vertex'"));
  EXPECT_TRUE(has(error("a.pcd", "FIELDS x y z\nPOINTS 1\nDATA binary\n"), "SIZE or TYPE"));
  EXPECT_TRUE(
      has(error("a.pcd", "FIELDS x y z\nPOINTS 1\nDATA zip\n"), "a.pcd:3:6: 'zip' is none"));
  EXPECT_TRUE(has(error("a.pcd", "FIELDS x y z\nSIZE 4 4 3\nTYPE F F F\nPOINTS 1\nDATA binary\n"),
                  "field 'z' has 3 bytes of type 'F'"));
  EXPECT_TRUE(has(error("a.pcd", "FIELDS x y z\nPOINTS 2\nDATA ascii\n1 2 3\n"),
                  "says 2 points, the file ends after 1"));
  EXPECT_TRUE(has(error("a.pcd", "FIELDS x y\nPOINTS 1\nDATA ascii\n1 2\n"), "no x, y and z"));
  EXPECT_TRUE(has(error("a.pcd", "FIELDS x y z\nPOINTS 1\nDATA ascii\n1 2\n"),
                  "2 columns; expected: 3 values of a point"));
  EXPECT_TRUE(has(error("a.ply",
                        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                        "property float y\nproperty float z\nend_header\n1 2 3 4\n"),
                  "a.ply:8:7: 4 columns; expected: 3 values of element 'vertex'"));
  EXPECT_THROW(read_points((folder / "absent.xyz").string()), Error);
  EXPECT_THROW(read_points(folder.string() + ".xyz"), Error);
}

// A column more, as where a decimal comma was taken for a separator, shifts the coordinates.
TEST_F(ReadPoints, RowsAreAllOfOneLength) {
  EXPECT_EQ(read_points(write("a.xyz", "1 2 3 255\n-4.5 0.5 6 0\n")).points, kExpected);
  EXPECT_TRUE(has(error("a.xyz", "1 2 3\n1,5 2 3\n"), "a.xyz:2:"));
  EXPECT_TRUE(has(error("a.xyz", "1 2 3\n1 2 3 4\n"),
                  "a.xyz:2:7: 4 columns; expected: x y z, and what else a point has (3 as in"));
  EXPECT_TRUE(has(error("a.csv", "1,2,3\n1,5,2,3\n"), "a.csv:2:7: 4 columns"));
  const std::string comma = "decimals are written with a point";
  EXPECT_TRUE(has(error("a.xyz", "1,5 2,5 3,5\n"), comma));
  EXPECT_TRUE(has(error("a.csv", "1,5;2,5;3,5\n"), comma));
}

// The square of such a coordinate overflows, and a search tree would split its box for ever.
TEST_F(ReadPoints, CoordinatesAreBounded) {
  EXPECT_TRUE(has(error("a.xyz", "1 2 3\n1 -1e300 3\n"), "a.xyz:2:3: '-1e300' is beyond 1e15"));
  EXPECT_TRUE(has(error("a.pcd", "FIELDS x y z\nPOINTS 1\nDATA ascii\n1 2 9e18\n"),
                  "a.pcd:4:5: '9e18' is beyond 1e15"));
  std::string ply =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty double x\n"
      "property double y\nproperty double z\nend_header\n";
  ply += bytes(1.0, false) + bytes(2.0, false) + bytes(1e300, false);
  EXPECT_TRUE(has(error("a.ply", ply), "a.ply: point 1 has a coordinate beyond 1e15"));
}

// Counts in a header are no reason to read beyond a row, to loop for long or to believe them.
TEST_F(ReadPoints, HeadersMayLie) {
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  EXPECT_TRUE(has(error("a.pcd",
                        "FIELDS a x y z\nCOUNT 18446744073709551615 1 1 1\nPOINTS 1\n"
                        "DATA ascii\n1 2\n"),
                  "a.pcd:2:7: '18446744073709551615' is larger than 1000"));
  EXPECT_TRUE(has(error("a.pcd",
                        "FIELDS x y z\nWIDTH 4294967296\nHEIGHT 4294967296\n"
                        "DATA ascii\n1 2 3\n"),
                  "is larger than"));
  EXPECT_TRUE(has(error("a.pcd", "FIELDS x y z\nPOINTS 1\nDATA ascii\n1 2 3\n4 5 6\n"),
                  "a.pcd:5:1: the header says 1 points, but more follow"));
  EXPECT_TRUE(has(error("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\n" + xyz +
                                     "end_header\n1 2 3\n4 5 6\n"),
                  "a.ply:9:1: the elements of the header have ended, but more follows"));
  EXPECT_TRUE(has(error("a.ply",
                        "ply\nformat binary_little_endian 1.0\n"
                        "element nothing 2000000000\nelement vertex 1\n" +
                            xyz + "end_header\n"),
                  "the file ends after 0"));
  EXPECT_TRUE(has(error("a.ply",
                        "ply\nformat binary_little_endian 1.0\nelement face 1\n"
                        "property list uint double i\nelement vertex 1\n" +
                            xyz + "end_header\n\xff\xff\xff\xff"),
                  "of element 'face', the file ends after 0"));
  EXPECT_TRUE(has(error("a.ply", "ply\nformat ascii 1.0\nelement vertex 99999999999999999999\n"),
                  "a.ply:3:16: '99999999999999999999' is larger than"));
}

}  // namespace
}  // namespace hybrid
