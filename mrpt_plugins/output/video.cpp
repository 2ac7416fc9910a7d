// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/video.h"

#include <fmt/format.h>

#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <string>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/output/output_directory.h"

namespace hybrid {
namespace {

void encode(const std::string& path, int count, const std::function<Image(int)>& picture,
            double pictures_per_second) {
  cv::VideoWriter writer;
  cv::Size size;
  for (int i = 0; i < count; ++i) {
    const Image image = picture(i);
    if (i == 0) {
      size = {image.width, image.height};
      const int codec = cv::VideoWriter::fourcc('m', 'p', '4', 'v');
      if (!writer.open(path, cv::CAP_FFMPEG, codec, pictures_per_second, size)) {
        throw Error(
            "OpenCV on this machine has no MPEG-4 encoder (mp4v); write single frames instead");
      }
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
}

std::filesystem::path folder_of(const std::filesystem::path& path) {
  if (path.extension() != ".mp4") {
    throw Error(fmt::format("cannot write '{}': the name of a video ends in .mp4", path.string()));
  }
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  if (std::filesystem::is_directory(folder)) return folder;
  throw Error(
      fmt::format("cannot write '{}': there is no folder '{}'", path.string(), folder.string()));
}

}  // namespace

void save_video(const std::filesystem::path& path, int count,
                const std::function<Image(int)>& picture, double pictures_per_second) {
  OutputDirectory(folder_of(path)).save(path.filename(), [&](const std::string& temporary) {
    encode(temporary, count, picture, pictures_per_second);
  });
}

void check_video(const std::filesystem::path& path) {
  const std::filesystem::path probe = folder_of(path) / (".probe-" + path.filename().string());
  const auto black = [](int) { return Image{64, 64, std::vector<std::uint8_t>(64 * 64 * 3)}; };
  try {
    save_video(probe, 1, black);
  } catch (const std::exception& e) {
    throw Error(fmt::format("cannot write video '{}': {}", path.string(), e.what()));
  }
  std::filesystem::remove(probe);
}

}  // namespace hybrid
