// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/session/detail/find_start.h"

#include <memory>
#include <utility>
#include <vector>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/geometry/isometry.h"
#include "libhybrid/scans/scan_join.h"
#include "libhybrid/scans/scan_place.h"
#include "mrpt_plugins/bridge/about_file.h"
#include "mrpt_plugins/map_file/export_map.h"
#include "mrpt_plugins/mapping/fix_source.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/mapping/scan_follower.h"
#include "mrpt_plugins/session/detail/localizer.h"
#include "mrpt_plugins/session/detail/open_logs.h"
#include "mrpt_plugins/session/detail/scan_places.h"

namespace hybrid {
namespace {

/// Way after which scans that have not told which of the places near a given start is right are
/// not waited for any longer [m].
constexpr double kFirstWay = 30.0;

/// Finds the place of a mapper by its laser scans.
class ScanLocalizer {
 public:
  ScanLocalizer(const MapRecord& map, const std::vector<std::shared_ptr<MappingPlugin>>& plugins,
                const ScanPlaceOptions& options) {
    if (!has_planar_scans(map)) return;
    for (const auto& plugin : plugins) {
      if (const auto* follower = dynamic_cast<const ScanFollower*>(plugin.get())) {
        follower_ = follower;
        search_.emplace(stored_scans(map), options);
      }
    }
  }

  std::optional<KnownStart> look() {
    const ScanMapper* own = mapper();
    const auto found = own == nullptr ? std::nullopt : search_->look(*own);
    if (!found) return std::nullopt;
    return KnownStart{to_isometry(found->motion), found->covariance};
  }

  /// That scans have followed [m].
  double way() const {
    const ScanMapper* own = mapper();
    if (own == nullptr || own->tracker().keyframes().empty()) return 0.0;
    return own->tracker().keyframes().back().travelled;
  }

 private:
  const ScanMapper* mapper() const {
    return follower_ == nullptr ? nullptr : follower_->scan_mapper(0);
  }

  const ScanFollower* follower_ = nullptr;
  std::optional<ScanPlaceSearch> search_;
};

/// The log of one robot, mapped in a frame of its own.
class OwnMap {
 public:
  OwnMap(const ReplayRequest& request, std::size_t robot, const MapRecord& map)
      : ini_(open_config(request)), settings_(read_settings(*ini_, request)) {
    settings_.robots = {std::move(settings_.robots[robot])};
    source_.emplace(open_logs(settings_));
    plugins_ = settings_.plugins;
    mapper_.emplace(make_mapper(settings_, source_->is_3d()));
    KnownMap kinds;  // without landmarks: these are not in the frame of the robot yet
    kinds.identified = map.identified;
    kinds.class_names = map.class_names;
    about(std::vector<std::string>{settings_.map.file}, [&] {
      mapper_->adopt(kinds);
      return 0;
    });
  }

  /// Adds the next keyframe; false at the end of the log, or if the program is asked to stop.
  bool add_next() {
    return about({settings_.robots.front().rawlog}, [&] {
      const auto keyframe = source_->next();
      if (!keyframe || interrupted() != 0) return false;
      mapper_->add(*keyframe);
      return true;
    });
  }

  const Mapper& mapper() const { return *mapper_; }
  const std::vector<std::shared_ptr<MappingPlugin>>& plugins() const { return plugins_; }

 private:
  std::unique_ptr<IniFile> ini_;
  ReplaySettings settings_;
  std::optional<LogMerge> source_;
  std::vector<std::shared_ptr<MappingPlugin>> plugins_;
  std::optional<Mapper> mapper_;
};

/// What fixes say, once they tell where the own map is on earth, if others have told that of the
/// known map.
std::optional<KnownStart> start_by_fixes(const OwnMap& own, const MapRecord& map) {
  const FixSource* source = fix_source_of(own.plugins());
  const std::optional<MapDatum> datum = source != nullptr ? source->datum() : std::nullopt;
  if (!datum || !datum->is_on_earth) return std::nullopt;
  const auto T = motion_by_fixes(map.origin, origin_of(*datum), map.is_3d);
  if (!T) return std::nullopt;
  const Backend& backend = own.mapper().backend();
  const Key first(key_letter::kPose, 0);
  return KnownStart{*T * isometry_at(backend.values(), first), backend.joint_covariance({first})};
}

}  // namespace

std::optional<FoundStart> find_start(const ReplayRequest& request, std::size_t robot,
                                     const MapRecord& map, double odds) {
  OwnMap own(request, robot, map);
  std::optional<Localizer> localizer;
  if (!map.landmarks.empty()) localizer.emplace(map, odds);
  ScanPlaceOptions options;
  options.odds = odds;
  ScanLocalizer scans(map, own.plugins(), options);
  std::optional<FoundStart> by_fixes;
  for (std::size_t i = 0; own.add_next(); ++i) {
    const auto start = localizer ? localizer->look(own.mapper()) : std::nullopt;
    if (start) return FoundStart{*start, i, false};
    if (const auto by_scans = scans.look()) return FoundStart{*by_scans, i, true};
    if (by_fixes) continue;
    if (const auto found = start_by_fixes(own, map)) by_fixes = FoundStart{*found, i, false};
  }
  return by_fixes;
}

std::optional<KnownStart> refine_start(const ReplayRequest& request, std::size_t robot,
                                       const MapRecord& map, double odds, const KnownStart& start) {
  if (!has_planar_scans(map)) return std::nullopt;
  OwnMap own(request, robot, map);
  ScanPlaceOptions options;
  options.odds = odds;
  options.start = {to_se2(start.T_map_robot), planar_covariance(start.covariance)};
  ScanLocalizer scans(map, own.plugins(), options);
  while (own.add_next()) {
    if (const auto found = scans.look()) return found;
    if (scans.way() > kFirstWay) break;
  }
  return std::nullopt;
}

}  // namespace hybrid
