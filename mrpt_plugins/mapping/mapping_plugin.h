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
#include "mrpt_plugins/bridge/ini_file.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/input/detections.h"
#include "mrpt_plugins/input/log_contents.h"

namespace HYBRID_API hybrid {

/// The keyframe that a plugin turns into factors.
struct Frame {
  Key pose;                          ///< its variable: SE2, or SE3 where `MapView::is_3d`
  mrpt::poses::CPose3D T_map_robot;  ///< its estimate before the observations are used
  const std::vector<DetectionFrame>& detections;
  /// Everything sensed there, of the classes that this program reads (CObservationBearingRange,
  /// CObservationClassedBearingRange, CObservationBeaconRanges) and of those that a plugin asks
  /// for.
  const std::vector<mrpt::obs::CObservation::Ptr>& observations;

  /// The same for the library, which knows no MRPT.
  KeyframeView view() const { return {pose, to_isometry(T_map_robot), detections}; }
};

/// Turns observations into hybrid factors. Derive, write the two virtual methods, register the
/// class with HYBRID_REGISTER_PLUGIN, and name it in [plugins] classes of the INI; a library of
/// your own is loaded with -p. A plugin sees neither files nor windows nor the solver.
class MappingPlugin : public mrpt::rtti::CObject {
  DEFINE_VIRTUAL_MRPT_OBJECT(MappingPlugin)

 public:
  /// Reads the parameters from the section named like the class; every key is declared with its
  /// default and meaning, whether or not the file has it.
  virtual void configure(IniSection section) = 0;

  /// Classes of further observations that the plugin looks at, with or without namespace. A log is
  /// parsed in a process of its own (rawlog/object_reader.h), from which objects of these classes
  /// come whole; of any other class only their time does.
  virtual std::vector<std::string> observation_classes() const { return {}; }

  /// All classes of observations that it makes factors of, with or without namespace: what a user
  /// is told, and whose observations are left to it where [plugins] classes = auto.
  virtual std::vector<std::string> uses() const { return observation_classes(); }

  /// Whether [plugins] classes = auto chooses it for a log; asked before it is configured. By
  /// default where the log holds a class that it uses.
  virtual bool suits(const LogContents& log) const;

  /// Told before the first keyframe of landmarks that are in the map already.
  virtual void adopt(const KnownMap&, bool /*is_3d*/) {}

  /// Log odds that a landmark is there, by id; one that is missing is taken to be there.
  virtual std::map<std::int64_t, double> existence() const { return {}; }

  /// Factors and variables for one keyframe. Throws Error where the observations make no sense.
  virtual Contribution observe(const Frame& frame, const MapView& map) = 0;

  /// Takes note of what became of the last contribution.
  virtual void applied(const Outcome&) {}

  /// Told instead of `applied` where the last contribution could not become part of the map, for
  /// instance because it left a variable undetermined: nothing of it is in the map. A plugin that
  /// keeps a state of its own goes back to what it was before.
  virtual void refused() {}

  /// A change of what was contributed before, asked for after every keyframe until it is empty.
  virtual Contribution revise(const MapView&) { return {}; }

  /// The same once no more keyframes come.
  virtual Contribution conclude(const MapView&) { return {}; }

  /// Figures for the summary of a run, by name; empty if there are none.
  virtual std::map<std::string, double> statistics() const { return {}; }

  /// Names of the values of the class variables this plugin makes; empty if it makes none.
  virtual std::vector<std::string> class_names() const { return {}; }

  /// What became of every detection given so far, at the present estimate, for evaluation; empty if
  /// the plugin takes the ids of the log for granted.
  virtual std::vector<AssociationDecision> decisions(const MapView&) const { return {}; }
};

/// Creates a plugin by class name (with or without namespace) and configures it from `[name]`.
/// Throws Error that lists the registered plugins for an unknown name.
std::shared_ptr<MappingPlugin> make_plugin(const std::string& class_name, IniFile& ini);

/// Class names, without namespace, of all plugins that can be created, sorted.
std::vector<std::string> registered_plugins();

}  // namespace hybrid
