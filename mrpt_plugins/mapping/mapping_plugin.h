// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/poses/CPose3D.h>
#include <mrpt/rtti/CObject.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "libhybrid/landmarks/association_decision.h"
#include "libhybrid/landmarks/contribution.h"
#include "libhybrid/landmarks/known_map.h"
#include "libhybrid/movers/mover.h"
#include "libhybrid/scans/laser_scan.h"
#include "mrpt_plugins/bridge/ini_file.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/input/detections.h"
#include "mrpt_plugins/input/fixes.h"
#include "mrpt_plugins/input/log_contents.h"
#include "mrpt_plugins/mrpt_version.h"

namespace HYBRID_API hybrid {

inline const std::vector<LaserScan> kNoScans;
inline const std::vector<LoggedFix> kNoFixes;

/// A keyframe for the plugins.
struct Frame {
  Key pose;                          ///< its variable: SE2, or SE3 where `MapView::is_3d`
  mrpt::poses::CPose3D T_map_robot;  ///< its estimate before the observations are used
  const std::vector<DetectionFrame>& detections;
  /// All observations of the keyframe that are of classes known to this program
  /// (CObservationBearingRange, CObservationClassedBearingRange, CObservationBeaconRanges,
  /// CObservation2DRangeScan) or requested by a plugin.
  const std::vector<mrpt::obs::CObservation::Ptr>& observations;
  /// Planar laser scans since the keyframe before, in order of time, those of the keyframe itself
  /// last.
  const std::vector<LaserScan>& scans = kNoScans;
  /// As those of KeyframeView: of `pose` and some variables of the map, in that order.
  std::function<Eigen::MatrixXd(const std::vector<Key>&)> joint_covariance = {};
  std::function<Eigen::MatrixXd(const std::vector<Key>&, const Eigen::MatrixXd& J)> covariance_of =
      {};
  /// Fixes of satellite receivers since the keyframe before, in order of time.
  const std::vector<LoggedFix>& fixes = kNoFixes;
  std::size_t robot = 0;  ///< of several, whose keyframe it is
  /// Whether odometry to it is known; else T_map_robot is the pose before.
  bool has_odometry = true;

  /// The same without MRPT types, for libhybrid.
  KeyframeView view() const {
    return {pose, to_isometry(T_map_robot), detections, joint_covariance, covariance_of};
  }
};

/// Converts observations into hybrid factors. Derive from it, implement the two pure virtual
/// methods, register the class with HYBRID_REGISTER_PLUGIN, and name it in [plugins] classes of the
/// INI. Option -p loads a library of your own. A plugin does not depend on files, windows or the
/// solver.
class MappingPlugin : public mrpt::rtti::CObject {
  HYBRID_DEFINE_VIRTUAL_MRPT_OBJECT(MappingPlugin, hybrid)

 public:
  /// Reads the parameters from the section named like the class. Every key is declared with its
  /// default and meaning, whether or not the file has it.
  virtual void configure(IniSection section) = 0;

  /// Further classes of observations that the plugin reads, with or without namespace. A separate
  /// process parses the log (rawlog/object_reader.h) and passes on whole objects of these classes;
  /// of other classes only the time.
  virtual std::vector<std::string> observation_classes() const { return {}; }

  /// All classes of observations that the plugin makes factors of, with or without namespace: for
  /// messages, and for the choice of plugins by [plugins] classes = auto.
  virtual std::vector<std::string> uses() const { return observation_classes(); }

  /// Whether [plugins] classes = auto chooses the plugin for a log; called before configure(). By
  /// default, whether the log holds a class that it uses.
  virtual bool suits(const LogContents& log) const;

  /// Whether the plugin uses the scans between keyframes too (Frame::scans). Where all plugins do
  /// and [keyframes] sets no threshold, keyframes are spaced out instead of taking every frame.
  virtual bool takes_scans_between() const { return false; }

  /// Whether later keyframes may be tied to any earlier one: then all stay in the graph of a
  /// bounded window.
  virtual bool ties_keyframes() const { return false; }

  /// Announces the known landmarks before the first keyframe.
  virtual void adopt(const KnownMap&, bool /*is_3d*/) {}

  /// Log odds of existence of landmarks by id; missing ones are taken to exist.
  virtual std::map<std::int64_t, double> existence() const { return {}; }

  /// What landmarks stand for, by id; missing ones are single things without an extent.
  virtual std::map<std::int64_t, LandmarkSize> sizes(const MapView&) const { return {}; }

  /// Factors and variables for one keyframe. Throws Error if the observations make no sense.
  virtual Contribution observe(const Frame& frame, const MapView& map) = 0;

  /// Called with the outcome of the last contribution once it is applied.
  virtual void applied(const Outcome&) {}

  /// Called instead of `applied` if the last contribution was refused, for instance because it left
  /// a variable undetermined, or, on trial, raised the objective too much: nothing of it is in the
  /// map. A plugin with a state of its own restores the former one.
  virtual void refused() {}

  /// A change of earlier contributions; called after every keyframe until it is empty.
  virtual Contribution revise(const MapView&) { return {}; }

  /// The same after the last keyframe.
  virtual Contribution conclude(const MapView&) { return {}; }

  /// Figures for the summary of a run, by name.
  virtual std::map<std::string, double> statistics() const { return {}; }

  /// Names of the values of the class variables that this plugin makes; empty if it makes none.
  virtual std::vector<std::string> class_names() const { return {}; }

  /// Things that move, which are no landmarks, at those of the `times` (in order, [s]) at which
  /// they were in sight.
  virtual std::vector<Mover> movers(const std::vector<double>& /*times*/, const MapView&) const {
    return {};
  }

  /// Attribution of every detection so far at the present estimate, for evaluation; empty if the
  /// plugin uses the ids of the log.
  virtual std::vector<AssociationDecision> decisions(const MapView&) const { return {}; }
};

/// Creates a plugin by class name (with or without namespace) and configures it from the section of
/// that name. Throws Error that lists the registered plugins for an unknown name.
std::shared_ptr<MappingPlugin> make_plugin(const std::string& class_name, IniFile& ini);

/// Class names, without namespace, of all plugins that can be created, sorted.
std::vector<std::string> registered_plugins();

}  // namespace hybrid
