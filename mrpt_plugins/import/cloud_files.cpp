// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/detail/cloud_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/io/folders.h"
#include "libhybrid/io/point_formats.h"
#include "libhybrid/io/regular_file.h"
#include "mrpt_plugins/import/detail/camera.h"
#include "mrpt_plugins/import/detail/read_boxes.h"

namespace hybrid {
namespace {

constexpr std::uint64_t kLargestCloud = std::uint64_t{1} << 30;  // bytes

bool is_digit(char c) {
  return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

/// Takes the number at the front of a name, without zeros before it.
std::string_view take_number(std::string_view& name) {
  const auto end = std::find_if_not(name.begin(), name.end(), is_digit);
  std::string_view digits = name.substr(0, static_cast<std::size_t>(end - name.begin()));
  name.remove_prefix(digits.size());
  digits.remove_prefix(std::min(digits.find_first_not_of('0'), digits.size()));
  return digits;
}

std::string extension_of(const std::string& name) {
  std::string end = std::filesystem::path(name).extension().string();
  for (char& c : end) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return end;
}

bool is_lidar_cloud(const std::string& name) {
  const std::string end = extension_of(name);
  return name.front() != '.' && (end == ".bin" || end == ".pcd" || end == ".ply");
}

bool is_image(const std::string& name) {
  return name.front() != '.' && extension_of(name) == ".png";
}

/// Sorts names by the times that they are, or else by their natural order.
void sort_clouds(CloudFolder& folder) {
  std::vector<std::pair<double, std::string>> stamped;
  for (const std::string& name : folder.clouds) {
    const std::optional<double> time = stamp_in(std::filesystem::path(name).stem().string());
    if (time) stamped.emplace_back(*time, name);
  }
  if (stamped.size() < folder.clouds.size()) {
    std::sort(folder.clouds.begin(), folder.clouds.end(), is_before);
    return;
  }
  std::sort(stamped.begin(), stamped.end());
  folder.clouds.clear();
  for (auto& [time, name] : stamped) {
    folder.stamps.push_back(time);
    folder.clouds.push_back(std::move(name));
  }
}

}  // namespace

bool is_before(const std::string& a, const std::string& b) {
  std::string_view left = a, right = b;
  while (!left.empty() && !right.empty()) {
    if (is_digit(left.front()) && is_digit(right.front())) {
      const std::string_view m = take_number(left), n = take_number(right);
      if (m.size() != n.size()) return m.size() < n.size();
      if (m != n) return m < n;
      continue;
    }
    if (left.front() != right.front()) return left.front() < right.front();
    left.remove_prefix(1);
    right.remove_prefix(1);
  }
  if (left.empty() != right.empty()) return left.empty();
  return a < b;
}

CloudFolder clouds_in(const std::string& folder) {
  std::vector<std::string> lidar, images, others;
  for (const FolderEntry& entry : entries_of(folder)) {
    if (entry.is_folder) continue;
    (is_lidar_cloud(entry.name) ? lidar
     : is_image(entry.name)     ? images
                                : others)
        .push_back(entry.name);
  }
  CloudFolder found;
  found.are_images = lidar.empty();
  if (!found.are_images) others.insert(others.end(), images.begin(), images.end());
  found.clouds = std::move(found.are_images ? images : lidar);
  if (found.clouds.empty()) {
    throw Error(fmt::format(
        "{}: no clouds; expected is a file for each: KITTI's F.bin, F.pcd, F.ply, or depth images "
        "F.png",
        folder));
  }
  sort_clouds(found);
  for (std::string& name : found.clouds) name = folder + "/" + name;
  found.others = others.size();
  if (!others.empty()) found.another = others.front();
  return found;
}

CloudFiles::CloudFiles(const CloudsOptions& options, bool are_images)
    : options_(options), are_images_(are_images) {
  if (are_images && !(options.focal > 0)) {
    throw Error(
        fmt::format("{}: depth images need --focal, the focal length in pixels", options.folder));
  }
}

CloudPoints CloudFiles::read(const std::string& path) {
  if (are_images_) return read_depths(path);
  PointFile file = extension_of(path) == ".bin" ? read_kitti(path) : read_cloud(path);
  CloudPoints cloud{std::move(file.points), std::move(file.times), file.left_out, 0};
  if (!(options_.max_range > 0)) return cloud;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    if (cloud.points[i].norm() > options_.max_range) continue;
    cloud.points[kept] = cloud.points[i];
    if (!cloud.times.empty()) cloud.times[kept] = cloud.times[i];
    ++kept;
  }
  cloud.too_far = cloud.points.size() - kept;
  cloud.points.resize(kept);
  cloud.times.resize(std::min(kept, cloud.times.size()));
  return cloud;
}

CloudPoints CloudFiles::read_depths(const std::string& path) {
  const std::optional<DepthImage> image = decoder_.decode(read_file(path, kLargestCloud));
  if (!image) throw Error(path + ": not a depth image, a PNG of one channel of 16 bits");
  const double u0 = options_.center_u < 0 ? image->width / 2.0 : options_.center_u;
  const double v0 = options_.center_v < 0 ? image->height / 2.0 : options_.center_v;
  CloudPoints cloud;
  auto depth = image->depths.begin();
  for (int v = 0; v < image->height; ++v) {
    for (int u = 0; u < image->width; ++u) {
      const double z = *depth++ * options_.depth_unit;
      if (z == 0) continue;
      if (options_.max_range > 0 && z > options_.max_range) {
        ++cloud.too_far;
        continue;
      }
      cloud.points.push_back(
          robot_point({(u - u0) / options_.focal * z, (v - v0) / options_.focal * z, z}));
    }
  }
  return cloud;
}

}  // namespace hybrid
