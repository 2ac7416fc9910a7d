// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/video.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <fstream>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <string>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

/// Opens a film with the best available encoder; returns a warning for the user, or "".
std::string open_film(cv::VideoWriter& writer, const std::string& path, const cv::Size& size,
                      double pictures_per_second) {
  const auto open = [&](int codec) {
    return writer.open(path, cv::CAP_FFMPEG, codec, pictures_per_second, size);
  };
  const bool is_even = size.width % 2 == 0 && size.height % 2 == 0;  // H.264 requires it
  if (is_even && open(cv::VideoWriter::fourcc('a', 'v', 'c', '1'))) return "";
  if (open(cv::VideoWriter::fourcc('m', 'p', '4', 'v'))) {
    return "the film is MPEG-4 part 2, which browsers do not play: OpenCV on this machine has no "
           "H.264 encoder";
  }
  throw Error(
      "OpenCV on this machine has neither an H.264 nor an MPEG-4 encoder, or the file cannot be "
      "created; write single frames instead");
}

std::string encode(const std::string& path, int count, const std::function<Image(int)>& picture,
                   double pictures_per_second) {
  cv::VideoWriter writer;
  cv::Size size;
  std::string note;
  for (int i = 0; i < count; ++i) {
    const Image image = picture(i);
    if (i == 0) {
      size = {image.width, image.height};
      note = open_film(writer, path, size, pictures_per_second);
    }
    if (image.width != size.width || image.height != size.height) {
      throw Error(fmt::format("picture {} is {} x {}, the first is {} x {}", i, image.width,
                              image.height, size.width, size.height));
    }
    const cv::Mat rgb(image.height, image.width, CV_8UC3,
                      const_cast<std::uint8_t*>(image.rgb.data()));
    cv::Mat bgr;
    cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
    writer.write(bgr);
  }
  return note;
}

/// The big-endian number of `count` bytes.
std::uint64_t big_endian(const unsigned char* bytes, int count) {
  std::uint64_t value = 0;
  for (int i = 0; i < count; ++i) value = value << 8U | bytes[i];
  return value;
}

/// Whether the boxes of an MP4 file (ISO/IEC 14496-12, 4.2) fill it exactly and one of them is the
/// index (moov). OpenCV writes the index last: without it, the film is incomplete.
bool has_whole_boxes(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const auto end = static_cast<std::uint64_t>(file.tellg());
  bool has_index = false;
  std::uint64_t at = 0;
  while (file && at < end) {
    std::array<unsigned char, 16> head{};
    file.seekg(static_cast<std::streamoff>(at));
    file.read(reinterpret_cast<char*>(head.data()), 8);
    std::uint64_t size = big_endian(head.data(), 4);
    if (size == 1) {
      file.read(reinterpret_cast<char*>(head.data() + 8), 8);
      size = big_endian(head.data() + 8, 8);
    }
    if (size < 8 || size > end - at) return false;
    has_index = has_index || std::string(head.begin() + 4, head.begin() + 8) == "moov";
    at += size;
  }
  return file && at == end && has_index;
}

}  // namespace

std::string encode_video(const std::filesystem::path& path, int count,
                         const std::function<Image(int)>& picture, double pictures_per_second) {
  std::string note = encode(path.string(), count, picture, pictures_per_second);
  // OpenCV does not report write errors.
  if (!has_whole_boxes(path.string())) {
    throw Error("the film is not complete; is the disk full?");
  }
  const cv::VideoCapture film(path.string(), cv::CAP_FFMPEG);
  const auto found = static_cast<int>(film.get(cv::CAP_PROP_FRAME_COUNT));
  if (found != count) throw Error(fmt::format("{} of {} pictures are in it", found, count));
  return note;
}

}  // namespace hybrid
