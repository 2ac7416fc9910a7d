// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Example of a mapping plugin in a library of its own: range and bearing to landmarks with known
// ids, with Huber's loss, for maps in 2-D. Load it with `hybrid-replay -p` and name it in [plugins]
// classes.

#include <algorithm>
#include <memory>

#include "libhybrid/detections/sighting.h"
#include "libhybrid/factors/bearing_range.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/mapping/register_plugin.h"

namespace example {

class RobustBearingRange : public hybrid::MappingPlugin {
  DEFINE_MRPT_OBJECT(RobustBearingRange, example)

 public:
  void configure(hybrid::IniSection section) override {
    width_ = section.get("huber_width", width_, "residuals beyond are outliers [sigmas]",
                         hybrid::kPositive);
  }

  std::vector<std::string> uses() const override {
    return {"CObservationBearingRange", "CObservationClassedBearingRange"};
  }

  hybrid::Contribution observe(const hybrid::Frame& frame, const hybrid::MapView& map) override {
    hybrid::Contribution out;
    for (const hybrid::DetectionFrame& seen : frame.detections) {
      for (const hybrid::Detection& detection : seen.detections) {
        if (map.is_3d || !detection.id) {
          ++out.dropped["example: in space or without id"];
        } else {
          add(frame, map, seen, detection, out);
        }
      }
    }
    return out;
  }

 private:
  /// Whether a landmark is neither in the map nor seen by another sensor of the same keyframe.
  static bool is_new(std::int64_t id, const hybrid::MapView& map, const hybrid::Contribution& out) {
    return map.landmarks.find(id) == nullptr &&
           std::none_of(out.landmarks.begin(), out.landmarks.end(),
                        [id](const hybrid::Landmark& landmark) { return landmark.id == id; });
  }

  void add(const hybrid::Frame& frame, const hybrid::MapView& map,
           const hybrid::DetectionFrame& seen, const hybrid::Detection& detection,
           hybrid::Contribution& out) const {
    const std::int64_t id = *detection.id;
    const hybrid::Key point('l', static_cast<std::uint64_t>(id));
    if (is_new(id, map, out)) {
      out.landmarks.push_back({id, point, std::nullopt, 0});
      hybrid::insert_point(out.delta.values, point,
                           hybrid::sighted_point(frame.view().T_map_robot, seen, detection),
                           map.is_3d);
    }
    out.sighted.push_back(id);
    out.delta.continuous.push_back(std::make_shared<hybrid::BearingRange2>(
        frame.pose, point, Eigen::Vector2d(detection.range, detection.yaw),
        hybrid::Noise::covariance(detection.covariance.topLeftCorner<2, 2>()),
        hybrid::to_se2(seen.T_robot_sensor), hybrid::Loss::huber(width_)));
  }

  double width_ = 3.0;
};

}  // namespace example

HYBRID_REGISTER_PLUGIN(RobustBearingRange, example)
