// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "libhybrid/association/spatial_grid.h"
#include "libhybrid/detections/class_model.h"
#include "libhybrid/landmarks/contribution.h"
#include "libhybrid/landmarks/known_map.h"
#include "libhybrid/movers/point_sighting.h"

namespace HYBRID_API hybrid {

/// A detection and what it is taken for.
struct Sighting {
  int frame = 0;  ///< number of the set of detections it came in
  Key pose;
  std::shared_ptr<const DetectionFrame> sensor;  ///< without its detections
  Detection detection;
  std::vector<double> phi;  ///< likelihood of each class; empty if not classified
  int track = -1;           ///< -1: clutter, or not decided
  std::vector<Handle> factors;
  double undetected = 1;  ///< share of landmarks that earlier looks have left undetected there
  double extent = 0;      ///< of a landmark that is made of it [m]
};

/// A landmark under observation: tentative, then confirmed.
struct Track {
  Key position;
  std::optional<DiscreteKey> class_key;
  std::vector<int> sightings;          ///< numbers of them, in order
  std::vector<double> class_evidence;  ///< log p(sightings | class) by class
  double sigma = 0;           ///< at most, of its position in the map when last asked for [m]
  std::vector<Handle> prior;  ///< of its class
  double undetected = 1;      ///< that of the sighting it was made of
  double existence = 0;       ///< log odds that there is such a landmark
  int last_keyframe = 0;
  int open = 0;  ///< factors that hold it and are not decided
  bool alive = true;
  int known_sightings = 0;  ///< before the first keyframe; 0: it was not known then
  int known_things = 1;     ///< that it stood for then
  double extent = 0;        ///< how far off what it stands for may be, a standard deviation [m]
};

/// Landmarks and sightings, and how a change of what belongs to what becomes a change of the graph.
/// Every method that adds factors notes where their handles go; `take_handles` fills them in.
class LandmarkTracks {
 public:
  const std::vector<Track>& tracks() const { return tracks_; }
  Track& track(int t) { return tracks_[t]; }
  const Track& track(int t) const { return tracks_[t]; }
  const std::vector<Sighting>& sightings() const { return sightings_; }
  Sighting& sighting(int s) { return sightings_[s]; }
  const Sighting& sighting(int s) const { return sightings_[s]; }
  /// The detection of a sighting as one of a track, with its extent; t < 0: of a track that is made
  /// of it.
  Detection detection_of(int s, int t) const;
  /// Where that puts its thing in the map, seen from this pose of the robot.
  PointSighting located(int s, int t, const Eigen::Isometry3d& T_map_robot, const Values& values,
                        bool is_3d) const;
  const SpatialGrid& grid() const { return grid_; }
  std::size_t alive() const { return alive_; }

  /// Notes a detection that belongs to no track yet. Returns its number.
  int note(Sighting sighting);

  /// Makes a landmark where sighting `s` puts it, seen from `T_map_robot`.
  int create(int s, const Eigen::Isometry3d& T_map_robot, const ClassModel& classes, bool is_3d,
             Contribution& out);
  /// Notes landmarks known before, which are in the map already, under their ids; each has one
  /// sighting, in frame 0 and from the pose Key(), so that they count as seen together, long ago.
  void adopt(const std::vector<KnownLandmark>& landmarks, const ClassModel& classes, bool is_3d);
  /// Takes sighting `s` for track `t`.
  void attach(int s, int t, bool is_3d, Contribution& out);
  /// The same in the books only; its factor is made elsewhere.
  void count(int s, int t, Contribution& out);
  /// Removes the factors of a sighting and, if it had a track, takes it from there.
  void detach(int s, Contribution& out);
  /// Adds a factor on behalf of sighting `s`.
  void add_factor(int s, HybridFactorPtr factor, Contribution& out);
  /// Removes a track that has no sightings left.
  void remove(int t, Contribution& out);
  /// Ends a track whose factors stay in the graph, with all its sightings.
  void retire(int t, Contribution& out);
  /// Takes a track for clutter: with its factors and sightings where these can go, or as `retire`.
  void discard(int t, const MapView& map, Contribution& out);
  /// Changes a number of a track.
  template <class T>
  void set(int t, T Track::*what, T value) {
    undo_.emplace_back([t, what, before = tracks_[t].*what](LandmarkTracks& all) {
      all.tracks_[t].*what = before;
    });
    tracks_[t].*what = value;
  }
  /// Gives the sightings of `from` to `into`, but for those that a frame has besides one of `into`,
  /// which become clutter, and removes it.
  void merge(int from, int into, bool is_3d, Contribution& out);

  /// Notes the handles of the last contribution.
  void take_handles(const AddedHandles& handles);
  /// From here on all that is done to tracks and sightings can be taken back, but for what is
  /// changed through references to them.
  void remember() { undo_.clear(); }
  /// Takes back what was done since then, or since the handles of a contribution were noted:
  /// sightings noted and tracks made are gone, and their numbers are given again.
  void take_back();

  /// Probability of each class given the sightings.
  std::vector<double> class_belief(const Track& track, const ClassModel& classes) const;
  /// log of the evidence that two landmarks have one class against two independent ones.
  double same_class(int a, int b, const ClassModel& classes) const;
  /// The poses that a track was first and last seen from.
  Key first_seen_from(int t) const { return sightings_[tracks_[t].sightings.front()].pose; }
  Key last_seen_from(int t) const { return sightings_[tracks_[t].sightings.back()].pose; }
  /// Whether a track has so many detections, those counted that were gathered to one.
  bool seen_times(int t, int times) const;
  /// Poses of its sightings, in order.
  std::vector<Key> seen_from(int t) const;
  /// Whether all poses that a track was seen from are in the graph, so that the factors of its
  /// sightings may be removed.
  bool is_whole(int t, const MapView& map) const;
  /// Whether the log gives a detection of a track an id.
  bool has_id(int t) const;
  /// Sightings of `a` in frames that show `b` as well, so that they are two or one sighting is
  /// clutter; up to a limit.
  std::vector<int> sightings_beside(int a, int b,
                                    std::size_t at_most = std::numeric_limits<int>::max()) const;
  bool seen_together(int a, int b) const { return !sightings_beside(a, b, 1).empty(); }
  /// Moves a track in the grid to its estimate.
  void place(int t, const Values& values);
  /// Places all tracks, or the next few in turn.
  void place_all(const Values& values);
  void place_some(const Values& values, int count);

 private:
  void join(int s, int t);
  void part(int s, int t);
  void move(int t, double x, double y);

  struct Slot {  // where the handle of an added factor goes
    int sighting = -1, track = -1;
  };

  std::vector<Track> tracks_;
  std::vector<Sighting> sightings_;
  SpatialGrid grid_;
  std::size_t alive_ = 0;
  std::size_t next_to_place_ = 0;
  std::array<std::vector<Slot>, 3> slots_;  // by kind of factor, in the order of the delta
  std::vector<std::function<void(LandmarkTracks&)>> undo_;  // in order
};

}  // namespace hybrid
