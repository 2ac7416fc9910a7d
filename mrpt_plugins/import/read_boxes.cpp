// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/detail/read_boxes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "libhybrid/core/error.h"
#include "libhybrid/io/escaped.h"
#include "libhybrid/io/folders.h"
#include "libhybrid/io/parse_number.h"
#include "libhybrid/io/text_reader.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMostJson = std::uintmax_t{1} << 30;  // bytes

/// A name without what Roboflow adds: `frame_0012_jpg.rf.HASH` is frame_0012.
std::string without_hash(const std::string& name) {
  const std::size_t hash = name.rfind(".rf.");
  if (hash == std::string::npos) return name;
  const std::size_t kind = name.rfind('_', hash);
  return name.substr(0, kind == std::string::npos ? hash : kind);
}

/// The number that a name ends in.
std::optional<std::int64_t> image_number(std::string name) {
  name = without_hash(name);
  while (!name.empty() && std::isdigit(static_cast<unsigned char>(name.back())) == 0) {
    name.pop_back();
  }
  std::size_t first = name.size();
  while (first > 0 && std::isdigit(static_cast<unsigned char>(name[first - 1])) != 0) --first;
  const std::string digits = name.substr(first);
  constexpr std::size_t kMostDigits = 9;
  const std::size_t leading = std::min(digits.find_first_not_of('0'), digits.size());
  if (digits.empty() || digits.size() - leading > kMostDigits) return std::nullopt;
  return std::stoll(digits);
}

/// Rows frame, id, left, top, width, height, score; further columns are not used.
ImageBoxes read_mot(const std::string& path) {
  ImageBoxes boxes;
  TextReader text(path);
  TextRow row;
  while (text.next(row)) {
    row.expect(7, 64, "frame, id, left, top, width, height and score");
    const double score = row.number(6);
    boxes.all.push_back({row.id(0, kMostImages), kNoClass, row.coordinate(2), row.coordinate(3),
                         row.coordinate(4), row.coordinate(5), score < 0 ? 1 : score});
  }
  for (const ImageBox& box : boxes.all) boxes.images.emplace(box.image, "");
  // The frames of a video between two with boxes have none.
  constexpr std::int64_t kLongest = 1000;
  std::int64_t last = boxes.images.empty() ? 0 : boxes.images.begin()->first;
  for (auto it = boxes.images.begin(); it != boxes.images.end(); last = it->first, ++it) {
    if (it->first - last > kLongest) continue;
    for (std::int64_t i = last + 1; i < it->first; ++i) boxes.images.emplace_hint(it, i, "");
  }
  return boxes;
}

/// A share of the image.
double share_in(const TextRow& row, std::size_t at) {
  constexpr double kRounded = 0.01;
  const double share = row.coordinate(at);
  if (share >= -kRounded && share <= 1 + kRounded) return share;
  const char* const names[] = {"x", "y", "width", "height"};
  row.fail(at, fmt::format("{} = {} is no share of the image: boxes of YOLO are from 0 to 1; are "
                           "these pixels?",
                           names[at - 1], share));
}

/// Gives images the numbers that their names end in, or numbers them in the order of the times that
/// their names are.
void number_images(const std::string& folder, std::vector<std::string> stems, ImageBoxes& boxes) {
  const auto is_stamped = [](const std::string& stem) { return stamp_in(stem).has_value(); };
  if (!std::all_of(stems.begin(), stems.end(), is_stamped)) {
    for (const std::string& stem : stems) {
      const auto number = image_number(stem);
      if (!number) {
        throw Error(fmt::format("{}/{}.txt: the name has no number of an image (1 to 9 digits)",
                                folder, stem));
      }
      boxes.add(folder, *number, stem);
    }
    return;
  }
  std::sort(stems.begin(), stems.end(),
            [](const std::string& a, const std::string& b) { return stamp_in(a) < stamp_in(b); });
  for (const std::string& stem : stems) {
    const auto number = static_cast<std::int64_t>(boxes.images.size());
    boxes.add(folder, number, stem);
    boxes.stamps.emplace(number, *stamp_in(stem));
  }
}

/// A file for each image, named by its number or its time, with rows class, middle, size and
/// perhaps the score, in shares of the image. classes.txt names the classes.
ImageBoxes read_yolo(const std::string& folder, const ImageBoxOptions& o) {
  if (!(o.image_width > 0 && o.image_height > 0)) {
    throw Error(folder +
                ": boxes of YOLO are shares of the image: --image-width and "
                "--image-height tell its size in pixels");
  }
  ImageBoxes boxes;
  std::vector<std::string> stems;
  for (const FolderEntry& entry : entries_of(folder)) {
    const fs::path path = fs::path(folder) / entry.name;
    if (path.extension() != ".txt") continue;
    if (entry.name == "classes.txt") {
      TextReader text(path.string(), TextFormat{TextFormat::Cut::kWords, ""});
      std::string_view line;
      for (std::int64_t i = 0; text.next_line(line); ++i) {
        boxes.classes.try_emplace(i,
                                  std::string(line.substr(0, line.find_last_not_of(" \t\r") + 1)));
      }
      continue;
    }
    stems.push_back(path.stem().string());
  }
  if (stems.empty()) throw Error(folder + ": no .txt file of an image is there");
  number_images(folder, stems, boxes);
  for (const auto& [number, stem] : boxes.images) {
    const std::string path = (fs::path(folder) / (stem + ".txt")).string();
    if (fs::file_size(path) == 0) continue;  // nothing was seen
    TextReader text(path, TextFormat{TextFormat::Cut::kWords, ""});
    TextRow row;
    while (text.next(row)) {
      row.expect(5, 7, "class, x, y, width, height and perhaps score and id");
      const double x = share_in(row, 1), y = share_in(row, 2);
      const double w = share_in(row, 3) * o.image_width, h = share_in(row, 4) * o.image_height;
      boxes.all.push_back({number, row.id(0), x * o.image_width - w / 2, y * o.image_height - h / 2,
                           w, h, row.size() > 5 ? row.number(5) : 1.0});
    }
  }
  return boxes;
}

/// A list of {image_id, category_id, bbox: [left, top, width, height], score}.
ImageBoxes read_coco(const std::string& path) {
  if (fs::file_size(path) > kMostJson) throw Error(path + ": more than 1 GiB");
  std::ifstream file(path);
  const nlohmann::json all = nlohmann::json::parse(file, nullptr, false);
  if (!all.is_array()) {
    throw Error(path +
                ": not the results of COCO, which are a list of objects with image_id, "
                "category_id, bbox and score");
  }
  ImageBoxes boxes;
  for (const nlohmann::json& entry : all) {
    const auto fail = [&](const char* what) {
      throw Error(fmt::format("{}: entry {}: {}", path, boxes.all.size() + 1, what));
    };
    const auto number = [&](const nlohmann::json& value, const char* what) {
      const bool good = value.is_number() && std::abs(value.get<double>()) <= kLargestCoordinate;
      if (!good) fail(what);
      return value.get<double>();
    };
    if (!entry.is_object()) fail("not an object");
    ImageBox box;
    const nlohmann::json id = entry.value("image_id", nlohmann::json());
    const auto image = id.is_string() ? image_number(id.get<std::string>())
                       : id.is_number_unsigned() && id.get<std::uint64_t>() < kMostImages
                           ? std::optional<std::int64_t>(id.get<std::int64_t>())
                           : std::nullopt;
    if (!image) fail("image_id is no number, or no name that ends in one of at most 9 digits");
    box.image = *image;
    boxes.add(path, *image, id.is_string() ? id.get<std::string>() : "");
    const nlohmann::json category = entry.value("category_id", nlohmann::json());
    if (!category.is_number_unsigned()) fail("category_id is no number");
    box.category = category.get<std::int64_t>();
    const nlohmann::json bbox = entry.value("bbox", nlohmann::json());
    if (!bbox.is_array() || bbox.size() != 4) fail("bbox has not four numbers");
    double* const parts[] = {&box.left, &box.top, &box.width, &box.height};
    for (std::size_t i = 0; i < 4; ++i) *parts[i] = number(bbox[i], "bbox has not four numbers");
    box.score = number(entry.value("score", nlohmann::json()), "score is no number");
    boxes.all.push_back(box);
  }
  return boxes;
}

}  // namespace

std::optional<double> stamp_in(const std::string& name) {
  double value = 0;
  if (name.find_first_not_of("0123456789.") != std::string::npos || !parse_number(name, value)) {
    return std::nullopt;
  }
  constexpr double kFirst = 1e9;  // s, of the year 2001
  if (name.find('.') != std::string::npos) return value;
  double unit = 1;
  while (value / unit >= 10 * kFirst) unit *= 1000;
  return value >= kFirst ? std::optional<double>(value / unit) : std::nullopt;
}

void ImageBoxes::add(const std::string& path, std::int64_t image, const std::string& name) {
  const auto [other, is_new] = images.emplace(image, name);
  if (is_new || other->second == name) return;
  throw Error(fmt::format("{}: {} and {} are both of image {}: give one camera at a time", path,
                          in_quotes(other->second), in_quotes(name), image));
}

ImageBoxes read_image_boxes(const DetectionTablesOptions& options) {
  const std::string& path = options.detections;
  ImageBoxes boxes = fs::is_directory(path)                  ? read_yolo(path, options.boxes)
                     : fs::path(path).extension() == ".json" ? read_coco(path)
                                                             : read_mot(path);
  std::stable_sort(boxes.all.begin(), boxes.all.end(),
                   [](const ImageBox& a, const ImageBox& b) { return a.image < b.image; });
  return boxes;
}

}  // namespace hybrid
