// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/detail/cloud_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <optional>
#include <string_view>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/io/folders.h"
#include "mrpt_plugins/import/detail/read_boxes.h"

namespace hybrid {
namespace {

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

bool is_lidar_cloud(const std::string& name) {
  const std::string end = extension_of(name);
  return name.front() != '.' && (end == ".bin" || end == ".pcd" || end == ".ply");
}

bool is_image(const std::string& name) {
  return name.front() != '.' && extension_of(name) == ".png";
}

/// Whether name `a` comes before `b` where runs of digits count as numbers: 2 before 10.
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

std::string extension_of(const std::string& name) {
  std::string end = std::filesystem::path(name).extension().string();
  for (char& c : end) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return end;
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

}  // namespace hybrid
