// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/replay/detail/map_place.h"

#include <fmt/format.h>

#include <algorithm>

#include "mrpt_plugins/bridge/about_file.h"
#include "mrpt_plugins/bridge/detail/standard_input.h"

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
  run_.emplace(options_, provenance(), request.resume, is_3d);
  if (run_->map().landmarks.empty()) return;
  if (const auto given = given_start(options_.start, is_3d)) {
    given_ = true;
    found_ = FoundStart{*given, 0};
  } else if (is_standard_input(settings.robots.front().rawlog)) {
    throw Error(options_.file +
                ": the place in it is found by reading the log before, which standard input does "
                "not allow; give [map] start");
  } else {
    found_ = find_start(with_chosen_plugins(request, settings), run_->map(), options_.odds);
  }
}

std::optional<KnownStart> MapPlace::start() const {
  return found_ ? std::make_optional(found_->start) : std::nullopt;
}

void MapPlace::enter(Mapper& mapper) {
  if (!run_ || lost()) return;
  about(std::vector<std::string>{options_.file}, [&] {
    if (found_) mapper.adopt(known_map(run_->map()));
    run_->begin();
    return 0;
  });
}

void MapPlace::added(std::size_t keyframe, Mapper& mapper) {
  if (!run_ || lost()) return;
  if (found_ && !given_ && keyframe == found_->keyframe) mapper.forget_start();
  run_->added(mapper);
}

void MapPlace::pause(const Mapper& mapper) {
  if (run_ && !lost()) run_->pause(mapper);
}

void MapPlace::tell(MapResult& result, Summary& summary) const {
  if (!run_) return;
  summary.uses_map = true;
  if (found_) summary.localized_at = found_->keyframe;
  if (lost() && summary.status == "ok") {
    summary.status = "partial";
    summary.message = fmt::format(
        "not found in {}: no place of it stands out, so the frame is that of the first pose and "
        "the map is as it was",
        options_.file);
  }
  if (!run_->localizes() || lost()) return;
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
                      const std::function<void()>& show) {
  if (run_ && !lost()) {
    run_->finish(mapper, result, show);
  } else {
    show();
  }
}

}  // namespace hybrid
