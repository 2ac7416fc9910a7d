// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/session/map_place.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "mrpt_plugins/bridge/about_file.h"
#include "mrpt_plugins/map_file/export_map.h"
#include "mrpt_plugins/plugins/bearing_range_association.h"

namespace hybrid {
namespace {

/// So much of a map that is in view is shown in the right place at least, to what is seen again
/// within seconds.
constexpr double kLeastShown = 0.85;
/// The same of landmarks, which are things that may have been moved: most still stand.
constexpr double kLeastStanding = 0.5;

/// Throws Error where new landmarks, which are numbered, would be among those with ids of logs.
void refuse_numbers(const ReplaySettings& settings, const MapRecord& map) {
  if (settings.map.localizes() || !map.identified || map.landmarks.empty()) return;
  for (const auto& plugin : settings.plugins) {
    if (dynamic_cast<const BearingRangeAssociation*>(plugin.get()) == nullptr) continue;
    throw Error(
        settings.map.file +
        ": its landmarks have the ids of logs, and those of this log would get numbers, which "
        "later logs would take for ids; --map-mode localize, or map this log into another file");
  }
}

}  // namespace

MapPlace::MapPlace(const ReplayRequest& request, const ReplaySettings& settings,
                   const std::function<Provenance()>& provenance, bool is_3d, std::string doubt)
    : options_(settings.map), doubt_(std::move(doubt)) {
  if (options_.file.empty()) {
    if (request.resume || options_.mode == "extend" || options_.localizes()) {
      throw Error("--resume, extend and localize need a map file: --map F.hmap, or [map] file");
    }
    return;
  }
  const std::string mode = settings.backend->mode();
  if (mode != "bounded" && mode != "incremental") {
    throw Error(options_.file + ": a map file needs [solver] mode = bounded or incremental");
  }
  std::vector<std::string> logs;
  for (const RobotSettings& robot : settings.robots) {
    logs.push_back(robot.rawlog);
    is_given_ = is_given_ || given_start(robot.start, is_3d).has_value();
  }
  run_.emplace(options_, provenance(), logs, request.resume, is_3d);
  refuse_numbers(settings, run_->map());
}

const MapRecord& MapPlace::map() const {
  static const MapRecord none;
  return run_ && doubt_.empty() ? run_->map() : none;
}

std::optional<MapOrigin> MapPlace::origin() const {
  if (lost_) return std::nullopt;
  return options_.origin ? options_.origin : map().origin;
}

void MapPlace::enter(Mapper& mapper, bool found) {
  if (!run_) return;
  lost_ = !found && holds_places(run_->map());
  if (lost_) return;
  about(std::vector<std::string>{options_.file}, [&] {
    if (found) mapper.adopt(known_map(run_->map()));
    const std::optional<MapOrigin>& place = run_->map().origin;
    if (found && place && place->by_fixes) mapper.adopt(datum_of(*place));
    run_->begin(mapper.robot_names());
    return 0;
  });
}

void MapPlace::added(const Mapper& mapper) {
  if (writes()) run_->added(mapper);
}

void MapPlace::pause(const Mapper& mapper) {
  if (writes()) run_->pause(mapper);
}

std::string MapPlace::doubt(const Agreement& with_map, bool has_views) const {
  if (!run_ || lost_) return "";
  const MapRecord& map = run_->map();
  const bool has_surfaces = has_clouds(map) || has_planar_scans(map);
  const char* views = has_clouds(map) ? "clouds" : has_surfaces ? "laser scans" : "detections";
  const char* what = has_surfaces ? "surfaces" : "landmarks";
  if (with_map.looks == 0 && has_surfaces && has_views && is_given_ && map.landmarks.empty()) {
    return fmt::format("none of its surfaces is in view of {} from the start that is given", views);
  }
  const double least = has_surfaces ? kLeastShown : kLeastStanding;
  if (with_map.looks == 0 || with_map.ratio + with_map.sigma > least) return "";
  return fmt::format("{} find {:.0f} % of its {} that are in view", views, 100 * with_map.late,
                     what);
}

void MapPlace::give_up(const std::string& doubt) {
  run_->give_up();
  doubt_ = doubt;
  lost_ = true;
}

void MapPlace::tell(MapResult& result, Summary& summary) const {
  if (!run_) return;
  summary.uses_map = true;
  if (lost_ && summary.status == "ok") {
    summary.status = "partial";
    summary.message = fmt::format(
        "not found in {}: {}, so the frame is that of the first pose and the map is as it was",
        options_.file, doubt_.empty() ? "no place of it stands out" : doubt_);
  }
  if (!localizes()) return;
  const auto& known = run_->map().landmarks;
  auto& all = result.landmarks;
  all.erase(std::remove_if(all.begin(), all.end(),
                           [&](const LandmarkEstimate& l) {
                             return std::none_of(known.begin(), known.end(),
                                                 [&](const auto& k) { return k.id == l.id; });
                           }),
            all.end());
  summary.landmarks = all.size();
}

void MapPlace::finish(const Mapper& mapper, const MapResult& result, const SeenPlaces& seen,
                      const std::function<void()>& show) {
  if (writes()) {
    run_->finish(mapper, result, seen, show);
  } else {
    show();
  }
}

}  // namespace hybrid
