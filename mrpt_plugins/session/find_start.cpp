// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/session/detail/find_start.h"

#include <memory>
#include <utility>
#include <vector>

#include "libhybrid/geometry/isometry.h"
#include "libhybrid/scans/scan_join.h"
#include "libhybrid/scans/scan_place.h"
#include "mrpt_plugins/bridge/about_file.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/mapping/scan_follower.h"
#include "mrpt_plugins/session/detail/localizer.h"
#include "mrpt_plugins/session/detail/open_logs.h"

namespace hybrid {
namespace {

/// Finds the place of a mapper by its laser scans.
class ScanLocalizer {
 public:
  ScanLocalizer(const MapRecord& map, const std::vector<std::shared_ptr<MappingPlugin>>& plugins,
                double odds) {
    if (map.local_maps.empty() || map.is_3d) return;
    for (const auto& plugin : plugins) {
      if (const auto* follower = dynamic_cast<const ScanFollower*>(plugin.get())) {
        follower_ = follower;
        ScanPlaceOptions options;
        options.odds = odds;
        search_.emplace(stored_scans(map), options);
      }
    }
  }

  std::optional<KnownStart> look() {
    const ScanMapper* own = follower_ == nullptr ? nullptr : follower_->scan_mapper(0);
    const auto found = own == nullptr ? std::nullopt : search_->look(*own);
    if (!found) return std::nullopt;
    return KnownStart{to_isometry(found->motion), found->covariance};
  }

 private:
  const ScanFollower* follower_ = nullptr;
  std::optional<ScanPlaceSearch> search_;
};

}  // namespace

std::optional<FoundStart> find_start(const ReplayRequest& request, std::size_t robot,
                                     const MapRecord& map, double odds) {
  const auto ini = open_config(request);
  ReplaySettings settings = read_settings(*ini, request);
  settings.robots = {std::move(settings.robots[robot])};
  LogMerge source = open_logs(settings);
  const std::vector<std::shared_ptr<MappingPlugin>> plugins = settings.plugins;
  Mapper mapper = make_mapper(settings, source.is_3d());
  KnownMap kinds;  // without landmarks: these are not in the frame of the robot yet
  kinds.identified = map.identified;
  kinds.class_names = map.class_names;
  about(std::vector<std::string>{settings.map.file}, [&] {
    mapper.adopt(kinds);
    return 0;
  });
  std::optional<Localizer> localizer;
  if (!map.landmarks.empty()) localizer.emplace(map, odds);
  ScanLocalizer scans(map, plugins, odds);
  return about({settings.robots.front().rawlog}, [&]() -> std::optional<FoundStart> {
    for (std::size_t i = 0; const auto keyframe = source.next(); ++i) {
      if (interrupted() != 0) break;
      mapper.add(*keyframe);
      const auto start = localizer ? localizer->look(mapper) : std::nullopt;
      if (start) return FoundStart{*start, i, false};
      if (const auto by_scans = scans.look()) return FoundStart{*by_scans, i, true};
    }
    return std::nullopt;
  });
}

}  // namespace hybrid
