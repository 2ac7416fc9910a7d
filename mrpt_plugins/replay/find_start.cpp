// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/replay/detail/find_start.h"

#include <utility>

#include "mrpt_plugins/bridge/about_file.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/replay/detail/localizer.h"
#include "mrpt_plugins/replay/settings.h"

namespace hybrid {

std::optional<FoundStart> find_start(const ReplayRequest& request, std::size_t robot,
                                     const MapRecord& map, double odds) {
  const auto ini = open_config(request);
  ReplaySettings settings = read_settings(*ini, request);
  settings.robots = {std::move(settings.robots[robot])};
  LogMerge source = open_logs(settings);
  Mapper mapper = make_mapper(settings, source.is_3d());
  KnownMap kinds;  // without landmarks: these are not in the frame of the robot yet
  kinds.identified = map.identified;
  kinds.class_names = map.class_names;
  about(std::vector<std::string>{settings.map.file}, [&] {
    mapper.adopt(kinds);
    return 0;
  });
  Localizer localizer(map, odds);
  return about({settings.robots.front().rawlog}, [&]() -> std::optional<FoundStart> {
    for (std::size_t i = 0; const auto keyframe = source.next(); ++i) {
      if (interrupted() != 0) break;
      mapper.add(*keyframe);
      if (const auto start = localizer.look(mapper)) return FoundStart{*start, i};
    }
    return std::nullopt;
  });
}

}  // namespace hybrid
