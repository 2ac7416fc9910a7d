// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/session/detail/find_start.h"

#include <memory>
#include <utility>
#include <vector>

#include "libhybrid/clouds/cloud_join.h"
#include "libhybrid/clouds/cloud_place.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/geometry/isometry.h"
#include "libhybrid/scans/scan_join.h"
#include "libhybrid/scans/scan_place.h"
#include "mrpt_plugins/bridge/about_file.h"
#include "mrpt_plugins/map_file/export_map.h"
#include "mrpt_plugins/mapping/cloud_follower.h"
#include "mrpt_plugins/mapping/fix_source.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/mapping/scan_follower.h"
#include "mrpt_plugins/session/detail/localizer.h"
#include "mrpt_plugins/session/detail/open_logs.h"
#include "mrpt_plugins/session/scan_places.h"

namespace hybrid {
namespace {

/// Way after which scans or clouds that have not told which of the places near a given start is
/// right are not waited for any longer [m].
constexpr double kFirstWay = 30.0;

/// Finds the place of a mapper by its laser scans, or by its clouds.
class PlaceLocalizer {
 public:
  /// `start`: where it begins, if that is roughly known.
  PlaceLocalizer(const MapRecord& map, const Plugins& plugins, double odds,
                 const std::optional<KnownStart>& start) {
    for (const auto& plugin : plugins) {
      if (has_planar_scans(map)) by_scans_ = dynamic_cast<const ScanFollower*>(plugin.get());
      if (has_clouds(map)) by_clouds_ = dynamic_cast<const CloudFollower*>(plugin.get());
      if (by_scans_ != nullptr || by_clouds_ != nullptr) break;
    }
    if (by_scans_ != nullptr) {
      ScanPlaceOptions options;
      options.odds = odds;
      if (start) options.start = {to_se2(start->T_map_robot), planar_covariance(start->covariance)};
      scans_.emplace(stored_scans(map), options);
    }
    if (by_clouds_ != nullptr) {
      CloudPlaceOptions options;
      options.odds = odds;
      if (start) {
        options.start = {to_se3(start->T_map_robot), spatial_covariance(start->covariance)};
      }
      clouds_.emplace(stored_clouds(map), options);
    }
  }

  std::optional<KnownStart> look() {
    if (const ScanMapper* own = scan_mapper()) {
      if (const auto found = scans_->look(*own)) {
        return KnownStart{to_isometry(found->motion), found->covariance};
      }
    }
    if (const CloudMapper* own = cloud_mapper()) {
      if (const auto found = clouds_->look(*own)) {
        return KnownStart{to_isometry(found->motion), found->covariance};
      }
    }
    return std::nullopt;
  }

  /// That scans or clouds have followed [m].
  double way() const {
    const ScanMapper* scans = scan_mapper();
    if (scans != nullptr && !scans->tracker().keyframes().empty()) {
      return scans->tracker().keyframes().back().travelled;
    }
    const CloudMapper* clouds = cloud_mapper();
    if (clouds == nullptr || clouds->tracker().local_maps().empty()) return 0.0;
    return clouds->tracker().local_maps().back().travelled.back();
  }

 private:
  const ScanMapper* scan_mapper() const {
    return by_scans_ == nullptr ? nullptr : by_scans_->scan_mapper(0);
  }
  const CloudMapper* cloud_mapper() const {
    return by_clouds_ == nullptr ? nullptr : by_clouds_->cloud_mapper(0);
  }

  const ScanFollower* by_scans_ = nullptr;
  const CloudFollower* by_clouds_ = nullptr;
  std::optional<ScanPlaceSearch> scans_;
  std::optional<CloudPlaceSearch> clouds_;
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
  PlaceLocalizer places(map, own.plugins(), odds, std::nullopt);
  std::optional<FoundStart> by_fixes;
  for (std::size_t i = 0; own.add_next(); ++i) {
    const auto start = localizer ? localizer->look(own.mapper()) : std::nullopt;
    if (start) return FoundStart{*start, i, false};
    if (const auto by_place = places.look()) return FoundStart{*by_place, i, true};
    if (by_fixes) continue;
    if (const auto found = start_by_fixes(own, map)) by_fixes = FoundStart{*found, i, false};
  }
  return by_fixes;
}

std::optional<KnownStart> refine_start(const ReplayRequest& request, std::size_t robot,
                                       const MapRecord& map, double odds, const KnownStart& start) {
  if (!has_planar_scans(map) && !has_clouds(map)) return std::nullopt;
  OwnMap own(request, robot, map);
  PlaceLocalizer places(map, own.plugins(), odds, start);
  while (own.add_next()) {
    if (const auto found = places.look()) return found;
    if (places.way() > kFirstWay) break;
  }
  return std::nullopt;
}

}  // namespace hybrid
