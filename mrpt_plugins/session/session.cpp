// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/session/session.h"

#include <algorithm>
#include <iterator>
#include <type_traits>

#include "libhybrid/clouds/cloud_join.h"
#include "libhybrid/core/error.h"
#include "libhybrid/online/known_places.h"
#include "libhybrid/scans/scan_join.h"
#include "mrpt_plugins/bridge/about_file.h"
#include "mrpt_plugins/bridge/interrupt.h"
#include "mrpt_plugins/bridge/standard_input.h"
#include "mrpt_plugins/session/detail/open_logs.h"

namespace hybrid {
namespace {

/// The scans or clouds of a map, each where the session has found it: those that were matched are
/// variables of its graph, within what the map says of their errors.
template <class Stored>
std::vector<Stored> found_by(const Values& values, std::vector<Stored> stored) {
  for (std::size_t i = 0; i < stored.size(); ++i) {
    auto& pose = stored[i].T_map_anchor.motion;
    if (values.contains(place_key(i))) pose = values.at<std::decay_t<decltype(pose)>>(place_key(i));
  }
  return stored;
}

}  // namespace

Session::Session(const ReplayRequest& request, ReplaySettings& settings,
                 const std::function<Provenance()>& provenance, const std::string& doubt)
    : settings_(settings),
      source_(open_logs(settings)),
      is_3d_(source_.is_3d()),
      place_(
          request, settings,
          [&] {
            begin_logs();
            return provenance();
          },
          is_3d_, doubt),
      team_(request, settings, place_.map(), is_3d_),
      plugins_(settings.plugins) {
  if (!team_.message().empty()) source_ = open_logs(settings);  // robots were left out
}

std::size_t Session::count_keyframes() const {
  LogMerge logs = open_logs(settings_);
  std::size_t count = 0;
  while (logs.next()) {
    throw_if_interrupted();
    ++count;
  }
  return count;
}

void Session::begin() {
  mapper_.emplace(make_mapper(settings_, is_3d_));
  place_.enter(*mapper_, team_.is_in_map());
  if (team_.is_in_map()) adopt_places(plugins_, place_.map(), settings_.robots);
}

/// The next keyframe; nothing at the end, or with a signal that asks to stop.
std::optional<Keyframe> Session::next_keyframe() {
  try {
    std::optional<Keyframe> keyframe = source_.next();
    if (keyframe) signal_ = interrupted();
    return signal_ == 0 ? keyframe : std::nullopt;
  } catch (const Interrupted& e) {
    signal_ = e.signal();
    return std::nullopt;
  }
}

/// Those that errors of a run may be about.
std::vector<std::string> Session::files() const {
  std::vector<std::string> files;
  for (const RobotSettings& robot : settings_.robots) files.push_back(shown_path(robot.rawlog));
  files.push_back(settings_.map.file);
  return files;
}

Error Session::no_frame() const {
  const std::string& why = source_.message();
  return Error(why.empty() ? "the log holds no frame to map" : why);
}

/// Throws Error for what holds no frame, before it is hashed for a map file.
void Session::begin_logs() {
  about(files(), [&] {
    if (!source_.begins()) throw no_frame();
    return 0;
  });
}

void Session::map(const Watch& watch) {
  last_ = about(files(), [&] {
    bool is_empty = true;
    while (const auto keyframe = next_keyframe()) {
      is_empty = false;
      const StepRecord* step = mapper_->add(*keyframe);
      if (step == nullptr) continue;
      team_.added(keyframe->robot, *mapper_);
      place_.added(*mapper_);
      watch(*step, *keyframe);
    }
    if (is_empty) {
      throw_if_interrupted();
      throw no_frame();
    }
    if (signal_ != 0) place_.pause(*mapper_);
    return mapper_->finish();
  });
}

const MapRecord& Session::known() const {
  static const MapRecord none;
  return team_.is_in_map() ? place_.map() : none;
}

Agreement Session::agreement(const std::vector<PlacedScan>& scans,
                             const std::vector<PlacedCloud>& clouds, double reach,
                             const DetectionArchive& detections, const Trajectory& path) const {
  const MapRecord& map = known();
  const Values& values = mapper_->backend().values();
  if (has_planar_scans(map)) return agreement_with_map(scans, found_by(values, stored_scans(map)));
  if (has_clouds(map))
    return agreement_with_map(clouds, reach, found_by(values, stored_clouds(map)));
  std::vector<KnownLandmark> landmarks;
  std::copy_if(map.landmarks.begin(), map.landmarks.end(), std::back_inserter(landmarks), exists);
  return landmarks.empty() ? Agreement()
                           : agreement_with_map(detections.placed(*mapper_, path), landmarks);
}

std::string Session::doubt(const Agreement& with_map, bool has_views) const {
  return signal_ == 0 && team_.is_in_map() ? place_.doubt(with_map, has_views) : "";
}

MapResult Session::result() const {
  MapResult result = about(files(), [&] { return mapper_->result(); });
  result.title = settings_.title;
  return result;
}

void Session::publish(const MapResult& result, const std::function<void()>& show) {
  SeenPlaces seen;
  if (place_.writes()) {
    const MapRecord& map = place_.map();
    seen = seen_places(plugins_, result, *mapper_,
                       is_3d_ ? map.local_clouds.size() : map.local_maps.size());
  }
  signal_ != 0 ? show() : place_.finish(*mapper_, result, seen, show);
}

}  // namespace hybrid
