// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/math/TPoint3D.h>
#include <mrpt/poses/CPose2D.h>
#include <mrpt/poses/CPose3D.h>
#include <mrpt/system/datetime.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "libhybrid/core/error.h"

namespace HYBRID_API hybrid {

/// std::string_view::starts_with of C++20.
inline bool starts_with(std::string_view text, std::string_view with) {
  return text.substr(0, with.size()) == with;
}

/// Numbers and texts one after the other, as the processor stores them: for another process of the
/// same machine.
class ByteWriter {
 public:
  template <class T>
  void put(T value) {
    static_assert(std::is_arithmetic_v<T> && !std::is_same_v<T, bool>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  void put_flag(bool value) { put<std::uint8_t>(value ? 1 : 0); }
  void put_text(std::string_view text) {
    put(static_cast<std::uint32_t>(text.size()));
    bytes_.append(text);
  }
  const std::string& bytes() const { return bytes_; }
  void clear() { bytes_.clear(); }

 private:
  std::string bytes_;
};

/// The reverse, from bytes that may be anything. Throws Error where there are too few of them or a
/// value is none of its type.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}

  template <class T>
  T get() {
    static_assert(std::is_arithmetic_v<T> && !std::is_same_v<T, bool>);
    T value;
    std::memcpy(&value, take(sizeof(T)).data(), sizeof(T));
    return value;
  }
  bool flag() {
    const auto value = get<std::uint8_t>();
    if (value > 1) throw Error("a flag is neither 0 nor 1");
    return value == 1;
  }
  std::string_view text() { return take(get<std::uint32_t>()); }
  /// A number of things that take at least `bytes_each`, which must still be there.
  std::size_t count(std::size_t bytes_each) {
    const auto count = get<std::uint32_t>();
    if (count > bytes_.size() / bytes_each) throw Error("there are fewer bytes than it says");
    return count;
  }
  /// Throws Error unless all was read.
  void expect_end() const {
    if (!bytes_.empty()) throw Error("there are more bytes than it says");
  }

 private:
  std::string_view take(std::size_t count) {
    if (count > bytes_.size()) throw Error("there are fewer bytes than it says");
    const std::string_view taken = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return taken;
  }

  std::string_view bytes_;
};

/// Several numbers, one after the other.
template <class... Numbers>
void put_all(ByteWriter& out, Numbers... numbers) {
  (out.put(numbers), ...);
}
template <class... Numbers>
void get_all(ByteReader& in, Numbers&... numbers) {
  ((numbers = in.get<Numbers>()), ...);
}

void write_points(ByteWriter& out, const std::vector<mrpt::math::TPoint3Df>& points);
std::vector<mrpt::math::TPoint3Df> read_points(ByteReader& in);

void write_time(ByteWriter& out, mrpt::system::TTimeStamp time);
mrpt::system::TTimeStamp read_time(ByteReader& in);

/// A pose in space by its rotation matrix, as logs hold it: no bit of it changes.
void write_pose(ByteWriter& out, const mrpt::poses::CPose3D& pose);
mrpt::poses::CPose3D read_pose_3d(ByteReader& in);
void write_pose(ByteWriter& out, const mrpt::poses::CPose2D& pose);
mrpt::poses::CPose2D read_pose_2d(ByteReader& in);

/// The entries of a matrix, row by row.
template <class Matrix>
void write_matrix(ByteWriter& out, const Matrix& matrix) {
  for (int i = 0; i < matrix.rows(); ++i) {
    for (int j = 0; j < matrix.cols(); ++j) out.put<double>(matrix(i, j));
  }
}
template <class Matrix>
void read_matrix(ByteReader& in, Matrix& matrix) {
  for (int i = 0; i < matrix.rows(); ++i) {
    for (int j = 0; j < matrix.cols(); ++j) matrix(i, j) = in.get<double>();
  }
}

}  // namespace hybrid
