// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/session/detail/map_place.h"

#include <fmt/format.h>

#include <algorithm>

#include "mrpt_plugins/bridge/about_file.h"

namespace hybrid {

MapPlace::MapPlace(const ReplayRequest& request, const ReplaySettings& settings,
                   const std::function<Provenance()>& provenance, bool is_3d)
    : options_(settings.map) {
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
  for (const RobotSettings& robot : settings.robots) logs.push_back(robot.rawlog);
  run_.emplace(options_, provenance(), logs, request.resume, is_3d);
}

const MapRecord& MapPlace::map() const {
  static const MapRecord none;
  return run_ ? run_->map() : none;
}

void MapPlace::enter(Mapper& mapper, bool found) {
  if (!run_) return;
  lost_ = !found && holds_places(run_->map());
  if (lost_) return;
  about(std::vector<std::string>{options_.file}, [&] {
    if (found) mapper.adopt(known_map(run_->map()));
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

void MapPlace::tell(MapResult& result, Summary& summary) const {
  if (!run_) return;
  summary.uses_map = true;
  if (lost_ && summary.status == "ok") {
    summary.status = "partial";
    summary.message = fmt::format(
        "not found in {}: no place of it stands out, so the frame is that of the first pose and "
        "the map is as it was",
        options_.file);
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

void MapPlace::finish(const Mapper& mapper, const MapResult& result,
                      const std::vector<MapLocalMap>& local_maps,
                      const std::function<void()>& show) {
  if (writes()) {
    run_->finish(mapper, result, local_maps, show);
  } else {
    show();
  }
}

}  // namespace hybrid
