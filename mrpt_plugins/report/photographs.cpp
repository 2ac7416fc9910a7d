// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/report/photographs.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "mrpt_plugins/bridge/interrupt.h"
#include "mrpt_plugins/bridge/log_files.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/drawing/mrpt_image.h"
#include "mrpt_plugins/drawing/photograph.h"
#include "mrpt_plugins/report/columns.h"
#include "mrpt_plugins/report/page.h"

namespace hybrid {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kQuality = 75;                     // of JPEG, of 100
constexpr std::uint64_t kMostPixels = 50000000;  // that are decoded: 150 MB
constexpr std::uintmax_t kMostFileBytes = 200000000;
constexpr std::size_t kMostNames = 1000;  // of files that are kept in mind: 20 MB
constexpr int kMostSegments = 1000;       // of a JPEG before its frame

Json matrix_json(const Eigen::Isometry3d& T) {
  Json out = Json::array();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) out.push_back(decimals(T(row, column), 6));
  }
  return out;
}

/// Bytes of a file, the highest first, as a number; 0 behind its end.
std::uint64_t number_at(std::ifstream& file, std::uint64_t place, int bytes) {
  file.clear();
  file.seekg(static_cast<std::streamoff>(place));
  std::uint64_t out = 0;
  for (int i = 0; i < bytes; ++i) {
    const int byte = file.get();
    if (byte < 0) return 0;
    out = out << 8U | static_cast<std::uint64_t>(byte);
  }
  return out;
}

/// Pixels of a PNG or JPEG file by its header, which costs nothing to read; none for other files.
std::optional<std::uint64_t> pixels_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (number_at(file, 0, 8) == 0x89504e470d0a1a0a) {
    return number_at(file, 16, 4) * number_at(file, 20, 4);
  }
  if (number_at(file, 0, 2) != 0xffd8) return std::nullopt;
  std::uint64_t place = 2;
  for (int segment = 0; segment < kMostSegments; ++segment) {
    const std::uint64_t marker = number_at(file, place, 2);
    if (marker >> 8U != 0xff) return std::nullopt;
    const bool is_frame = marker >= 0xffc0 && marker <= 0xffcf && marker != 0xffc4 &&
                          marker != 0xffc8 && marker != 0xffcc;
    if (is_frame) return number_at(file, place + 5, 2) * number_at(file, place + 7, 2);
    place += 2 + number_at(file, place + 2, 2);
  }
  return std::nullopt;
}

/// The bytes of a file; none where it is no picture that can be decoded in a moment.
std::string picture_bytes(const std::filesystem::path& file) {
  const auto pixels = pixels_of(file);
  if (!pixels || *pixels == 0 || *pixels >= kMostPixels) return {};
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace

void Photographs::add(int keyframe, const std::vector<mrpt::obs::CObservation::Ptr>& observations,
                      const std::string& rawlog) {
  for (const auto& observation : observations) {
    const auto* image = dynamic_cast<const mrpt::obs::CObservationImage*>(observation.get());
    if (image == nullptr || count_++ % every_ != 0) continue;
    keep(keyframe, *image, rawlog);
    while (bytes_ > kMostBytes && kept_.size() > 1) thin();
  }
}

/// Nothing where the parameters are none of a camera that was calibrated, as MRPT's defaults.
std::optional<Photographs::Camera> Photographs::camera_of(
    const mrpt::obs::CObservationImage& observation, const Small& small) {
  const mrpt::img::TCamera& from = observation.cameraParams;
  const auto inside = [](double at, double size) { return at > 0 && at < size; };
  const Eigen::Isometry3d T = to_isometry(observation.cameraPose);
  const bool is_known = std::isfinite(from.fx()) && std::isfinite(from.fy()) && from.fx() > 1 &&
                        from.fy() > 1 && inside(from.cx(), from.ncols) &&
                        inside(from.cy(), from.nrows) && T.matrix().allFinite();
  if (!is_known) return std::nullopt;
  const double x = static_cast<double>(small.width) / from.ncols;
  const double y = static_cast<double>(small.height) / from.nrows;
  return Camera{x * from.fx(), y * from.fy(), x * from.cx(), y * from.cy(), T};
}

/// The picture that the log has, or that is in the file that it names.
Photographs::Small Photographs::small_of(const mrpt::img::CImage& image,
                                         const std::string& rawlog) try {
  const auto small_jpeg = [](const Image& small) {
    return Small{small.width, small.height, jpeg(small, kQuality)};
  };
  if (!image.isExternallyStored()) return small_jpeg(shrunk(image_of(image), kWidth));
  const auto file = named_file(image.getExternalStorageFile(), rawlog, kMostFileBytes);
  if (!file) return {};
  const auto known = files_.find(file->string());
  if (known != files_.end()) return known->second;
  if (files_.size() >= kMostNames) files_.clear();
  Small& small = files_[file->string()];
  const std::string bytes = picture_bytes(*file);
  if (bytes.empty()) return small;
  const auto decoded = decoder_.decode(bytes);
  if (decoded) small = small_jpeg(*decoded);
  return small;
} catch (const Interrupted&) {
  throw;
} catch (const std::exception&) {
  return {};
}

void Photographs::keep(int keyframe, const mrpt::obs::CObservationImage& observation,
                       const std::string& rawlog) {
  Small small = small_of(observation.image, rawlog);
  if (small.jpeg.empty()) {
    ++unreadable_;
    return;
  }
  Photograph photograph;
  photograph.keyframe = keyframe;
  photograph.sensor = observation.sensorLabel;
  photograph.width = small.width;
  photograph.height = small.height;
  photograph.camera = camera_of(observation, small);
  photograph.jpeg = std::move(small.jpeg);
  bytes_ += photograph.jpeg.size();
  kept_.push_back(std::move(photograph));
}

void Photographs::thin() {
  every_ *= 2;
  std::vector<Photograph> rest;
  bytes_ = 0;
  for (std::size_t i = 0; i < kept_.size(); i += 2) {
    bytes_ += kept_[i].jpeg.size();
    rest.push_back(std::move(kept_[i]));
  }
  kept_ = std::move(rest);
}

Json Photographs::json() const {
  Json list = Json::array();
  for (const Photograph& p : kept_) {
    Json camera = nullptr;
    if (p.camera) {
      camera = {{"f", {digits(p.camera->fx), digits(p.camera->fy)}},
                {"c", {digits(p.camera->cx), digits(p.camera->cy)}},
                {"T", matrix_json(p.camera->T_robot_camera)}};
    }
    list.push_back({{"k", p.keyframe},
                    {"sensor", p.sensor},
                    {"size", {p.width, p.height}},
                    {"camera", std::move(camera)},
                    {"jpeg", base64(p.jpeg)}});
  }
  return {{"list", std::move(list)}, {"every", every_}, {"unreadable", unreadable_}};
}

}  // namespace hybrid
