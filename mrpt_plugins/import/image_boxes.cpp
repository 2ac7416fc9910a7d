// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/detail/image_boxes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "libhybrid/core/error.h"
#include "libhybrid/io/escaped.h"
#include "mrpt_plugins/import/detail/detection_steps.h"
#include "mrpt_plugins/import/detail/log_time.h"
#include "mrpt_plugins/import/detail/read_boxes.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

/// NAME=VALUE of an option.
std::pair<std::string, std::string> halves(const std::string& text, const char* option) {
  const std::size_t at = text.find('=');
  if (at == 0 || at == std::string::npos || at + 1 == text.size()) {
    throw Error(fmt::format("{} {}: expected A=B", option, in_quotes(text)));
  }
  return {text.substr(0, at), text.substr(at + 1)};
}

/// The times of images.
class ImageClock {
 public:
  ImageClock(const ImageBoxOptions& o, const std::map<std::int64_t, double>& stamps)
      : options_(o), times_(stamps) {
    if (o.frame_times.empty()) {
      if (!times_.empty()) return;
      constexpr double kLongest = 1e6;  // s
      if (!(std::abs(o.start) <= kLargestTime) || o.period > kLongest) {
        throw Error(fmt::format("--start is at most {} s, and --period at most {} s", kLargestTime,
                                kLongest));
      }
      if (o.period > 0) return;
      throw Error(
          "boxes have numbers of images and no times: --period tells the seconds between "
          "images, or --frame-times a table frame,time");
    }
    NamedTable table(o.frame_times, {"frame", "time"}, {{"timestamp", "time"}, {"image", "frame"}});
    table.require({"frame", "time"});
    times_.clear();
    while (table.next()) {
      times_[table.row().id(table.column("frame"), kMostImages)] = table.time();
    }
  }
  const std::string& table() const { return options_.frame_times; }
  /// Whether times follow from the numbers of images.
  bool is_counted() const { return options_.frame_times.empty() && times_.empty(); }
  /// None for an image that the table lacks.
  std::optional<double> at(std::int64_t image) const {
    if (is_counted()) {
      return log_time(options_.start + static_cast<double>(image) * options_.period);
    }
    const auto it = times_.find(image);
    return it == times_.end() ? std::nullopt : std::optional(log_time(it->second));
  }

 private:
  const ImageBoxOptions& options_;
  std::map<std::int64_t, double> times_;
};

/// What the camera and the classes say of boxes.
class BoxCamera {
 public:
  BoxCamera(const ImageBoxOptions& o, std::map<std::int64_t, std::string> names)
      : o_(o), names_(std::move(names)) {
    if (!(o.focal > 0)) {
      throw Error("boxes become directions by the camera: --focal is its focal length in pixels");
    }
    center_u_ = o.center_u >= 0 ? o.center_u : o.image_width / 2;
    center_v_ = o.center_v >= 0 ? o.center_v : o.image_height / 2;
    if (!(center_u_ > 0)) {
      throw Error(
          "--center-u, the column that the camera looks along, or --image-width must be "
          "given in pixels");
    }
    for (const std::string& text : o.class_names) {
      const auto [number, name] = halves(text, "--class-name");
      if (number.find_first_not_of("0123456789") != std::string::npos || number.size() > 9) {
        throw Error(fmt::format("--class-name {}: expected NUMBER=NAME", in_quotes(text)));
      }
      names_[std::stoll(number)] = name;
    }
    for (const std::string& text : o.class_heights) {
      const auto [name, metres] = halves(text, "--class-height");
      char* end = nullptr;
      const double height = std::strtod(metres.c_str(), &end);
      if (*end != '\0' || !(height > 0 && height < 1e4)) {
        throw Error(fmt::format("--class-height {}: expected NAME=METRES", in_quotes(text)));
      }
      heights_[name] = height;
    }
  }

  std::string name_of(const ImageBox& box) const {
    if (box.category == kNoClass) return {};
    const auto it = names_.find(box.category);
    return it == names_.end() ? fmt::format("class_{}", box.category) : it->second;
  }
  bool has_heights() const { return !heights_.empty(); }
  /// Throws Error for a height of a class that no box has.
  void check_heights(const std::set<std::string>& classes) const {
    for (const auto& [name, height] : heights_) {
      if (classes.count(name) != 0) continue;
      throw Error(fmt::format("--class-height {}: no box is of that class; classes are: {}",
                              in_quotes(name), fmt::join(classes, " ")));
    }
  }

  /// Why a box tells no direction; null where it does.
  const char* fault(const ImageBox& box) const {
    if (!(box.width > 0 && box.height > 0)) return "box dropped: without width or height";
    if (box.score < o_.min_score) return "box dropped: score too low";
    const bool cut =
        o_.image_width > 0 && (box.left <= 1 || box.left + box.width >= o_.image_width - 1);
    return cut ? "box dropped: cut by the left or right border of the image" : nullptr;
  }

  /// Its direction, and its range where the height of its class is known and the box shows all of
  /// it; the noise of the direction is that of the options.
  CObservationClassedBearingRange::Detection detection(const ImageBox& box, bool is_3d) const {
    const double x = (box.left + box.width / 2 - center_u_) / o_.focal;
    const double y = is_3d ? (box.top + box.height / 2 - center_v_) / o_.focal : 0;
    CObservationClassedBearingRange::Detection d;
    d.yaw = static_cast<float>(-std::atan(x));
    d.pitch = static_cast<float>(std::atan2(y, std::hypot(1, x)));
    const auto it = heights_.find(name_of(box));
    const bool cut =
        o_.image_height > 0 && (box.top <= 1 || box.top + box.height >= o_.image_height - 1);
    if (it == heights_.end() || cut) return d;
    const double r = o_.focal * it->second / box.height * std::hypot(1, x, y);
    d.range = static_cast<float>(r);
    d.std_range = static_cast<float>(r * std::hypot(o_.sigma_height, o_.sigma_pixels / box.height));
    return d;
  }
  /// Full angle in view [rad]; 0: not known.
  double fov() const {
    return o_.image_width > 0 ? 2 * std::atan(o_.image_width / 2 / o_.focal) : 0;
  }

 private:
  const ImageBoxOptions& o_;
  std::map<std::int64_t, std::string> names_;
  std::map<std::string, double> heights_;
  double center_u_ = 0, center_v_ = 0;
};

std::vector<float> scores_of_box(const std::string& name, double score,
                                 const std::vector<std::string>& classes) {
  if (name.empty()) return {};
  if (classes.size() == 1) return {1.0F};
  const double others = (1 - score) / static_cast<double>(classes.size() - 1);
  std::vector<float> out(classes.size(), static_cast<float>(others));
  const auto it = std::find(classes.begin(), classes.end(), name);
  out[static_cast<std::size_t>(it - classes.begin())] = static_cast<float>(score);
  return out;
}

}  // namespace

bool are_image_boxes(const std::string& path) {
  if (fs::is_directory(path)) return true;
  const std::string ending = fs::path(path).extension().string();
  if (ending == ".json") return fs::exists(path);
  if (ending != ".txt" || !fs::is_regular_file(path) || fs::file_size(path) == 0) return false;
  TextRow row;
  return TextReader(path).next(row) && starts_like_a_number(row[0]);
}

namespace {

/// The classes of a log of these boxes. Throws Error where scores or classes are none.
std::vector<std::string> classes_of(const std::vector<ImageBox>& boxes, const BoxCamera& camera,
                                    const DetectionTablesOptions& options) {
  const std::string& path = options.detections;
  std::set<std::string> met;
  for (const ImageBox& box : boxes) {
    const std::string name = camera.name_of(box);
    if (!name.empty()) met.insert(name);
    if (!name.empty() && (box.score < 0 || box.score > 1)) {
      const bool is_whole = box.score == std::floor(box.score);
      throw Error(fmt::format(
          "{}: a box of image {} has the score {}, which is no probability{}", path, box.image,
          box.score, is_whole ? "; is it the id of a tracker? A score comes before it" : ""));
    }
  }
  camera.check_heights(met);
  const std::vector<std::string> classes =
      options.classes.empty() ? std::vector<std::string>(met.begin(), met.end()) : options.classes;
  for (const std::string& name : met) {
    if (std::find(classes.begin(), classes.end(), name) != classes.end()) continue;
    throw Error(fmt::format("{}: class {} is not among --classes", path, in_quotes(name)));
  }
  return classes;
}

/// Adds a frame for each image, also for one without boxes; returns the time of the first.
double add_images(const ImageBoxes& boxes, const BoxCamera& camera, const ImageClock& clock,
                  const std::vector<std::string>& classes, DetectionSteps& steps, LogWriter& log) {
  const bool is_3d = steps.is_3d();
  double first = 0;
  auto box = boxes.all.begin();
  for (const auto& [image, name] : boxes.images) {
    const auto done = static_cast<double>(box - boxes.all.begin());
    log.used(done / static_cast<double>(std::max<std::size_t>(1, boxes.all.size())));
    const std::optional<double> time = clock.at(image);
    if (time) {
      if (!std::isfinite(steps.time())) first = *time;
      if (*time < steps.time()) {
        throw Error(fmt::format("{}: time goes backwards at image {}", clock.table(), image));
      }
      if (!steps.is_of(*time)) {
        steps.end();
        steps.begin(*time, camera.has_heights(), is_3d, classes);
      }
    }
    for (; box != boxes.all.end() && box->image == image; ++box) {
      const char* fault = camera.fault(*box);
      if (fault == nullptr && !time) fault = "box dropped: --frame-times has not its image";
      if (fault != nullptr) {
        log.drop(fault);
        continue;
      }
      auto d = camera.detection(*box, is_3d);
      d.class_scores = scores_of_box(camera.name_of(*box), box->score, classes);
      auto& frame = d.range > 0 ? steps.frame() : steps.directions();
      frame.detections.push_back(std::move(d));
    }
  }
  return first;
}

}  // namespace

ImportReport import_image_boxes(const DetectionTablesOptions& options, LogWriter& log) {
  const std::string& path = options.detections;
  const bool is_json = fs::path(path).extension() == ".json";
  ImageBoxes boxes = read_image_boxes(options);
  const BoxCamera camera(options.boxes, std::move(boxes.classes));
  const ImageClock clock(options.boxes, boxes.stamps);
  const std::vector<std::string> classes = classes_of(boxes.all, camera, options);
  DetectionTablesOptions seen = options;
  if (seen.fov == 0) seen.fov = camera.fov();
  DetectionSteps steps(seen, log);
  const bool is_3d = steps.is_3d();
  if (is_3d && options.boxes.center_v < 0 && options.boxes.image_height == 0) {
    throw Error(
        "the odometry is in space: --center-v, the row that the camera looks along, or "
        "--image-height must be given in pixels");
  }
  const double first = add_images(boxes, camera, clock, classes, steps, log);
  steps.end();
  steps.finish(0);
  log.note_end(options.odometry);
  if (!is_json) log.note_end(path);  // a part of a list is none
  if (clock.is_counted() && !boxes.images.empty() && boxes.images.begin()->first == 1) {
    log.note(
        fmt::format("{}: images are numbered from 1: that one is taken to be of {:.6g} s, since "
                    "--start is the time of image 0",
                    path, *clock.at(1)));
  }
  if (log.steps() == 0) {
    throw Error(fmt::format(
        "{}: no box has odometry around it: they are of {} to {} s, and the odometry begins at {} "
        "s; {}",
        path, first, std::max(first, steps.time()), steps.start_of_odometry(),
        boxes.stamps.empty() ? "--start is the time of image 0"
                             : "the names of the images are taken for their times"));
  }
  return log.finish();
}

}  // namespace hybrid
