// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/report/photographs.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/drawing/mrpt_image.h"
#include "mrpt_plugins/report/columns.h"
#include "mrpt_plugins/report/page.h"

namespace hybrid {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kQuality = 75;  // of JPEG, of 100

Json matrix_json(const Eigen::Isometry3d& T) {
  Json out = Json::array();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) out.push_back(decimals(T(row, column), 6));
  }
  return out;
}

/// The folder of the images that a log only names.
std::filesystem::path images_of(const std::string& rawlog) {
  const std::filesystem::path log(rawlog);
  const auto own = log.parent_path() / (log.stem().string() + "_Images");
  std::error_code error;
  return std::filesystem::is_directory(own, error) ? own : log.parent_path() / "Images";
}

/// The pixels; nothing where they cannot be read. A log may name a regular file of its folder only:
/// of a folder, the size that MRPT makes room for is no size, and for a pipe it would wait.
std::optional<Image> image_in(const mrpt::img::CImage& image, const std::string& rawlog) {
  try {
    if (!image.isExternallyStored()) return image_of(image);
    const std::filesystem::path name = image.getExternalStorageFile();
    if (name != name.filename() || name == "..") return std::nullopt;
    const std::filesystem::path file = images_of(rawlog) / name;
    if (!std::filesystem::is_regular_file(file)) return std::nullopt;
    mrpt::img::CImage loaded;
    if (!loaded.loadFromFile(file.string())) return std::nullopt;
    return image_of(loaded);
  } catch (const std::exception&) {
    return std::nullopt;
  }
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
    const mrpt::obs::CObservationImage& observation, const Image& small) {
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

void Photographs::keep(int keyframe, const mrpt::obs::CObservationImage& observation,
                       const std::string& rawlog) {
  std::optional<Image> image = image_in(observation.image, rawlog);
  if (!image) {
    ++unreadable_;
    return;
  }
  const Image small = shrunk(*image, kWidth);
  Photograph photograph;
  photograph.keyframe = keyframe;
  photograph.sensor = observation.sensorLabel;
  photograph.width = small.width;
  photograph.height = small.height;
  photograph.jpeg = jpeg(small, kQuality);
  photograph.camera = camera_of(observation, small);
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
