// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/detail/depth_files.h"

#include <array>
#include <filesystem>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/io/binary_number.h"
#include "libhybrid/io/point_formats.h"
#include "libhybrid/io/regular_file.h"
#include "libhybrid/io/text_reader.h"
#include "mrpt_plugins/rawlog/decoder.h"

namespace hybrid {
namespace {

constexpr std::size_t kMostNumbers = 10'000'000;  // pixels, or points
constexpr int kUndistortions = 5;                 // iterations, as many as OpenCV's

constexpr BinaryNumber kCount{4, 'u'}, kRange{2, 'u'}, kFloat{4, 'f'};

/// Numbers of a file that may be compressed.
class NumberFile {
 public:
  explicit NumberFile(const std::string& path)
      : file_(path),
        decoder_([this](char* to, std::size_t count) { return file_.read(to, count); }) {}

  std::string bytes(std::size_t count) {
    std::string out(count, '\0');
    for (std::size_t done = 0; done < count;) {
      const std::size_t got = decoder_.read(&out[done], count - done);
      if (got == 0) fail("the file is too short");
      done += got;
    }
    return out;
  }
  std::size_t count() { return count_in(bytes(4)); }
  std::size_t count_in(const std::string& bytes) const {
    const double number = value_of(bytes.data(), kCount, false);
    if (number > kMostNumbers) fail("more than ten million points, or no such file");
    return static_cast<std::size_t>(number);
  }
  std::vector<float> numbers(std::size_t count, BinaryNumber type) {
    if (count > kMostNumbers) fail("more than ten million points");
    const auto size = static_cast<std::size_t>(type.bytes);
    const std::string all = bytes(count * size);
    std::vector<float> out(count);
    for (std::size_t i = 0; i < count; ++i) {
      out[i] = static_cast<float>(value_of(&all[i * size], type, false));
    }
    return out;
  }
  void expect_end() {
    char more = 0;
    if (decoder_.read(&more, 1) > 0) fail("the file is too long");
    if (decoder_.end() != DecodeEnd::kSound) fail(decoder_.message());
  }
  [[noreturn]] void fail(const std::string& what) const { throw Error(file_.path() + ": " + what); }

 private:
  RegularFile file_;
  Decoder decoder_;
};

bool is_text(const std::string& path) {
  const std::string end = std::filesystem::path(path).extension().string();
  return end == ".txt" || end == ".TXT";
}

/// Rows of as many numbers.
RangeImage read_text(const std::string& path) {
  TextReader text(path, {TextFormat::Cut::kCells, "%#"});
  RangeImage image;
  TextRow row;
  while (text.next(row)) {
    row.expect_same(image.columns, 1, "a number for each column");
    for (std::size_t i = 0; i < row.size(); ++i) {
      image.ranges.push_back(static_cast<float>(row.number(i)));
    }
    ++image.rows;
    if (image.ranges.size() > kMostNumbers) text.fail("more than ten million pixels");
  }
  return image;
}

/// Whether a file begins so that is an object of MRPT: the length of a name and its first letters.
bool begins_object(const std::string& head) {
  constexpr unsigned char kMark = 0x80;
  return (static_cast<unsigned char>(head[0]) & kMark) != 0 && head[3] != 0;
}

/// The matrix of floating numbers that MRPT before 2.1 wrote as an object, behind the first bytes.
RangeImage read_metric(NumberFile& file, const std::string& head) {
  constexpr unsigned char kLengthBits = 0x7f;
  const std::size_t length = static_cast<unsigned char>(head[0]) & kLengthBits;
  if (length + 1 < head.size()) file.fail("no range image");
  std::string name = head.substr(1) + file.bytes(length + 1 - head.size());
  name.erase(0, name.rfind(':') + 1);
  if (name != "CMatrix" && name != "CMatrixF") file.fail("no range image");
  file.bytes(1);  // the version of its form, which never changed
  RangeImage image;
  image.is_metric = true;
  image.rows = file.count();
  image.columns = file.count();
  image.ranges = file.numbers(image.rows * image.columns, kFloat);
  file.bytes(1);  // the mark of its end
  return image;
}

/// Where a ray meets the plane at distance 1 without the distortion of the lens.
std::pair<double, double> undistorted(double x, double y, const std::array<double, 8>& k) {
  const double x0 = x, y0 = y;
  for (int i = 0; i < kUndistortions; ++i) {
    const double r = x * x + y * y;
    const double radial =
        (1 + ((k[7] * r + k[6]) * r + k[5]) * r) / (1 + ((k[4] * r + k[1]) * r + k[0]) * r);
    if (radial < 0) return {x0, y0};
    const double dx = 2 * k[2] * x * y + k[3] * (r + 2 * x * x);
    const double dy = k[2] * (r + 2 * y * y) + 2 * k[3] * x * y;
    x = (x0 - dx) * radial;
    y = (y0 - dy) * radial;
  }
  return {x, y};
}

}  // namespace

PointFile read_coordinates(const std::string& path) {
  if (is_text(path)) return read_rows(path);
  NumberFile file(path);
  std::array<std::vector<float>, 3> all;
  for (std::vector<float>& axis : all) {
    const std::size_t count = file.count();
    if (&axis != &all[0] && count != all[0].size()) file.fail("coordinates differ in number");
    axis = file.numbers(count, kFloat);
  }
  file.expect_end();
  PointFile out;
  for (std::size_t i = 0; i < all[0].size(); ++i) {
    add_point(out, Eigen::Vector3f(all[0][i], all[1][i], all[2][i]).cast<double>(), path);
  }
  return out;
}

RangeImage read_ranges(const std::string& path) {
  if (is_text(path)) return read_text(path);
  NumberFile file(path);
  const std::string head = file.bytes(4);
  RangeImage image;
  if (begins_object(head)) {
    image = read_metric(file, head);
  } else {
    image.rows = file.count_in(head);
    image.columns = file.count();
    image.ranges = file.numbers(image.rows * image.columns, kRange);
  }
  file.expect_end();
  return image;
}

PointFile unprojected(const RangeImage& image, const DepthCamera& camera) {
  PointFile out;
  auto range = image.ranges.begin();
  for (std::size_t row = 0; row < image.rows; ++row) {
    for (std::size_t column = 0; column < image.columns; ++column) {
      const double seen = *range++ * (image.is_metric ? 1.0 : camera.unit);
      if (!(seen > 0)) continue;
      const auto [x, y] =
          undistorted((static_cast<double>(column) - camera.cx) / camera.fx,
                      (static_cast<double>(row) - camera.cy) / camera.fy, camera.distortion);
      const Eigen::Vector3d ray(1, -x, -y);
      add_point(out, seen * (camera.is_depth ? ray : ray.normalized()), "a range image");
    }
  }
  return out;
}

}  // namespace hybrid
