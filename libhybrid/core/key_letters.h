// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

/// The letters of keys and who gives them. Small letters belong to those who build graphs: to you,
/// and to the readers, mappers and programs listed here. Capital letters belong to the library: it
/// adds such variables to graphs of users, so that theirs never collide with it.
namespace hybrid::key_letter {

// Pose graphs and maps.
inline constexpr char kPose = 'x';                 ///< pose graphs, mapper
inline constexpr char kLandmark = 'l';             ///< position; pose graphs, mapping plugins
inline constexpr char kLandmarkClass = 's';        ///< mapping plugins
inline constexpr char kMotionMode = 'm';           ///< mapper, switching systems
inline constexpr char kSensorPose = 'c';           ///< mapper
inline constexpr char kOdometryCalibration = 'o';  ///< mapper
inline constexpr char kAssociation = 'a';          ///< what a frame saw; mapping plugins
inline constexpr char kRangeChoice = 'b';          ///< which place a range means; mapping plugins
inline constexpr char kBearingChoice = 'v';        ///< whether a bearing is false; mapping plugins

// Other programs.
inline constexpr char kObject = 'o';       ///< pose; object maps
inline constexpr char kAnchor = 'a';       ///< position of a fixed transmitter; hybrid-switching
inline constexpr char kCounterpart = 'd';  ///< of a point; registration

// Added by the library.
inline constexpr char kClosureSwitch = 'D';  ///< whether a closure is true; closures
inline constexpr char kHypothesis = 'H';     ///< of an edge with several; pose graphs
inline constexpr char kClosureChoice = 'R';  ///< with its three values; closures
inline constexpr char kClosureWeight = 'S';  ///< switchable constraints; baselines
inline constexpr char kComponent = 'K';      ///< of a mixture that has no variable of its own

}  // namespace hybrid::key_letter
