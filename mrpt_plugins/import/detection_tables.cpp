// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/detection_tables.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "libhybrid/core/error.h"
#include "libhybrid/io/escaped.h"
#include "mrpt_plugins/import/detail/detection_steps.h"
#include "mrpt_plugins/import/detail/image_boxes.h"

namespace hybrid {
namespace {

const std::vector<std::string> kDetectionColumns{
    "time",  "range", "yaw",     "pitch",       "x",         "y",           "z",     "class",
    "score", "id",    "true_id", "sigma_range", "sigma_yaw", "sigma_pitch", "p_NAME"};

/// All classes of the columns p_NAME, or else in column class, sorted.
std::vector<std::string> classes_in(const std::string& path) {
  NamedTable table(path, kDetectionColumns, kColumnAliases);
  const std::vector<std::string> probable = table.probable_classes();
  if (!probable.empty()) return probable;
  std::set<std::string> names;
  while (table.has("class") && table.next()) {
    if (!table.word("class").empty()) names.insert(table.word("class"));
  }
  return {names.begin(), names.end()};
}

/// A number within 0 and 1.
double probability(const NamedTable& table, const std::string& name) {
  const double p = table.number(name);
  if (p < 0 || p > 1) table.fail(name, name + " not within 0 and 1");
  return p;
}

/// The columns p_NAME of a row; nothing where all are empty.
std::vector<float> probabilities_of(const NamedTable& table,
                                    const std::vector<std::string>& classes) {
  std::vector<float> scores;
  bool any = false;
  for (const std::string& name : classes) {
    const std::string column = std::string(kProbabilityPrefix) + name;
    const bool stated = table.has(column) && !table.word(column).empty();
    scores.push_back(stated ? static_cast<float>(probability(table, column)) : 0.0F);
    any = any || stated;
  }
  return any ? scores : std::vector<float>();
}

std::vector<float> scores_of(const NamedTable& table, const std::vector<std::string>& classes,
                             double usual) {
  if (!table.probable_classes().empty()) return probabilities_of(table, classes);
  if (!table.has("class") || table.word("class").empty()) return {};
  const auto it = std::find(classes.begin(), classes.end(), table.word("class"));
  if (it == classes.end()) {
    table.fail("class", fmt::format("unknown class {}; classes are: {}",
                                    in_quotes(table.word("class")), fmt::join(classes, " ")));
  }
  const bool scored = table.has("score") && !table.word("score").empty();
  const double score = scored ? probability(table, "score") : usual;
  if (classes.size() == 1) return {1.0F};
  const double others = (1 - score) / static_cast<double>(classes.size() - 1);
  std::vector<float> scores(classes.size(), static_cast<float>(others));
  scores[static_cast<std::size_t>(it - classes.begin())] = static_cast<float>(score);
  return scores;
}

/// Whether detections are places as the sensor sees them, x ahead, y to the left and z up, in place
/// of ranges and angles.
bool has_places(const NamedTable& table) {
  return table.has("x") || table.has("y") || table.has("z");
}

/// Whether detections have a range, stated or of their place.
bool has_ranges(const NamedTable& table) {
  return table.has("range") || has_places(table);
}

double range_of(const NamedTable& table) {
  if (!has_places(table)) return table.number("range");
  return std::hypot(table.number("x"), table.number("y"), table.has("z") ? table.number("z") : 0);
}

double yaw_of(const NamedTable& table) {
  return has_places(table) ? std::atan2(table.number("y"), table.number("x")) : table.angle("yaw");
}

/// Positive is down.
double pitch_of(const NamedTable& table) {
  if (!has_places(table)) return table.angle("pitch");
  return -std::atan2(table.number("z"), std::hypot(table.number("x"), table.number("y")));
}

/// Ids of a table, which are numbers, or names that are numbered from 0 as they come.
class DetectionIds {
 public:
  /// Nothing where the column is absent or the field empty or -1. What the first id is, all are.
  std::optional<std::int32_t> of(const NamedTable& table, const std::string& column) {
    if (!table.has(column) || table.word(column).empty() || table.word(column) == "-1") return {};
    const std::string word = table.word(column);
    const bool is_name = !starts_like_a_number(word);
    if (!are_names_) are_names_ = is_name;
    if (is_name != *are_names_) {
      table.fail(column, fmt::format("{} among ids that are {}: all are whole numbers, or all are "
                                     "names that begin with a letter",
                                     in_quotes(word), *are_names_ ? "names" : "numbers"));
    }
    if (!is_name) return static_cast<std::int32_t>(*table.id(column));
    const auto next = static_cast<std::int32_t>(names_.size());
    const auto [known, is_new] = numbers_.emplace(word, next);
    if (is_new) names_.push_back(word);
    return known->second;
  }

  /// Writes which number stands for which name.
  void write(LogWriter& log) const {
    for (std::size_t i = 0; i < names_.size(); ++i) {
      log.name_of(static_cast<std::int64_t>(i), names_[i]);
    }
    if (names_.empty()) return;
    log.note(
        fmt::format("{} ids are names: numbered from 0 in the order in which they come, as "
                    "the file of ids tells",
                    names_.size()));
  }

 private:
  std::optional<bool> are_names_;  // once there is an id
  std::map<std::string, std::int32_t> numbers_;
  std::vector<std::string> names_;
};

/// Refuses a table that lacks columns, or has those of both kinds.
void check_columns(const NamedTable& table) {
  if (has_places(table)) {
    table.require({"time", "x", "y"});
    if (table.has("range") || table.has("yaw") || table.has("pitch")) {
      table.refuse("columns x, y beside range or yaw: one or the other");
    }
    return;
  }
  if (table.has("yaw") || !table.has("range") || !table.has("id")) table.require({"time", "yaw"});
  table.require({"time"});
}

/// Noise that depends on the range, where the table states none.
void set_noise_by_range(const DetectionTablesOptions& o, bool has_range,
                        CObservationClassedBearingRange::Detection& d) {
  CObservationClassedBearingRange::Detection usual = d;
  set_noise({o.sigma_range, o.sigma_range_share, o.sigma_bearing, has_range ? o.sigma_across : 0},
            usual);
  if (d.std_range == 0 && o.sigma_range_share > 0) d.std_range = usual.std_range;
  if (o.sigma_across == 0 || !has_range) return;
  if (d.std_yaw == 0) d.std_yaw = usual.std_yaw;
  if (d.std_pitch == 0) d.std_pitch = usual.std_pitch;
}

void add_detection(const NamedTable& table, const std::vector<std::string>& classes,
                   const DetectionTablesOptions& options, DetectionIds& ids,
                   CObservationClassedBearingRange& frame) {
  CObservationClassedBearingRange::Detection d;
  if (frame.has_range) d.range = static_cast<float>(range_of(table));
  d.yaw = static_cast<float>(yaw_of(table));
  if (frame.has_pitch) d.pitch = static_cast<float>(pitch_of(table));
  if (const auto id = ids.of(table, "id")) d.landmark_id = *id;
  if (const auto id = ids.of(table, "true_id")) d.true_landmark_id = *id;
  d.std_range = static_cast<float>(table.sigma("sigma_range"));
  d.std_yaw = static_cast<float>(table.sigma("sigma_yaw"));
  d.std_pitch = static_cast<float>(table.sigma("sigma_pitch"));
  set_noise_by_range(options, frame.has_range, d);
  d.class_scores = scores_of(table, classes, options.score);
  frame.detections.push_back(std::move(d));
}

/// Refuses columns of classes that do not go together, and tells where classes are taken as
/// certain.
void check_classes(const NamedTable& table, const std::vector<std::string>& classes,
                   const DetectionTablesOptions& options, LogWriter& log) {
  for (const std::string& name : table.probable_classes()) {
    if (std::find(classes.begin(), classes.end(), name) == classes.end()) {
      table.refuse(fmt::format("column p_{}: unknown class; classes are: {}", name,
                               fmt::join(classes, " ")));
    }
  }
  if (!table.probable_classes().empty() && (table.has("class") || table.has("score"))) {
    table.refuse("columns p_NAME beside class or score: one or the other");
  }
  if (table.has("class") && !table.has("score") && options.score == 1 && classes.size() > 1) {
    log.note(options.detections +
             ": no column score: classes are taken as certain; where the detector may be wrong, "
             "--score tells how often it is right");
  }
}

/// A log of odometry and satellite fixes.
ImportReport import_fixes_alone(const DetectionTablesOptions& options, LogWriter& log) {
  if (options.fixes.table.empty()) throw Error("neither --detections nor --fixes is given");
  DetectionSteps steps(options, log);
  steps.finish(0);
  log.note_end(options.odometry);
  return log.finish();
}

}  // namespace

ImportReport import_detection_tables(const DetectionTablesOptions& options,
                                     const std::string& output) {
  if (options.sensor_pose.size() != 6) throw Error("a sensor pose has six numbers");
  if (!(options.score > 0 && options.score <= 1))
    throw Error("--score must be above 0 and at most 1");
  LogWriter log(output);
  if (options.detections.empty()) return import_fixes_alone(options, log);
  if (are_image_boxes(options.detections)) return import_image_boxes(options, log);
  const std::vector<std::string> classes =
      options.classes.empty() ? classes_in(options.detections) : options.classes;
  NamedTable table(options.detections, kDetectionColumns, kColumnAliases);
  check_columns(table);
  check_classes(table, classes, options, log);
  DetectionSteps steps(options, log);
  DetectionIds ids;
  double first = 0;
  std::size_t identified = 0;
  while (table.next()) {
    log.used(table.share());
    const double time = table.time();
    if (!std::isfinite(steps.time())) first = time;
    if (time < steps.time()) table.fail("time", "time goes backwards: sort the rows by it");
    if (!steps.is_of(time)) {
      steps.end();
      steps.begin(time, has_ranges(table), table.has("pitch") || table.has("z"), classes);
    }
    if (has_ranges(table) && range_of(table) <= 0) {
      log.drop("detection dropped: range not positive");
    } else if (!table.has("yaw") && !has_places(table)) {
      const double range = range_of(table), stated = table.sigma("sigma_range");
      const double usual = std::hypot(options.sigma_range, options.sigma_range_share * range);
      steps.add_range(range, stated > 0 ? stated : usual, ids.of(table, "id").value_or(-1));
    } else {
      add_detection(table, classes, options, ids, steps.frame());
      if (steps.frame().detections.back().landmark_id >= 0) ++identified;
    }
  }
  steps.end();
  steps.finish(identified);
  ids.write(log);
  for (const std::string& name : table.ignored()) {
    log.note(fmt::format("{}: column {} is left aside", table.path(), name.empty() ? "''" : name));
  }
  table.note_blanks(log);
  log.note_end(options.odometry);
  log.note_end(options.detections);
  if (!std::isfinite(steps.time())) throw Error(options.detections + ": no detections");
  if (log.steps() == 0) {
    throw Error(
        fmt::format("{}: no detection has odometry around it: they are of {} to {} s, and "
                    "the odometry begins at {} s; times of both are of one clock",
                    options.detections, first, steps.time(), steps.start_of_odometry()));
  }
  return log.finish();
}

}  // namespace hybrid
