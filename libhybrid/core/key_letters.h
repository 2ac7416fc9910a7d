// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

/// The letters of keys and the code that assigns them. Lower-case letters are for those who build
/// graphs: users, and the readers, mappers and programs listed here. Upper-case letters are for the
/// variables that the library adds to graphs of users, so that the two never collide.
namespace hybrid::key_letter {

// Pose graphs and maps.
inline constexpr char kPose = 'x';                 ///< pose graphs, mapper
inline constexpr char kLandmark = 'l';             ///< position; pose graphs, mapping plugins
inline constexpr char kLandmarkClass = 's';        ///< mapping plugins
inline constexpr char kMotionMode = 'm';           ///< mapper, switching systems
inline constexpr char kSensorPose = 'c';           ///< mapper
inline constexpr char kOdometryCalibration = 'o';  ///< mapper
inline constexpr char kAssociation = 'a';          ///< landmarks that a frame saw; mapping plugins
inline constexpr char kRangeChoice = 'b';          ///< mode of an ambiguous range; mapping plugins
inline constexpr char kBearingChoice = 'v';        ///< whether a bearing is false; mapping plugins
inline constexpr char kFixError = 'e';             ///< that lasts; fixes
inline constexpr char kFixErrorMode = 'r';         ///< its ErrorMode; fixes
inline constexpr char kFalseFix = 'f';             ///< whether a fix is false; fixes

// Other programs.
inline constexpr char kObject = 'o';       ///< pose; object maps
inline constexpr char kAnchor = 'a';       ///< position of a fixed transmitter; hybrid-switching
inline constexpr char kCounterpart = 'd';  ///< match of a source point; registration

// Added by the library.
inline constexpr char kClosureSwitch = 'D';  ///< switch of a closure, eq. 16; closures
inline constexpr char kHypothesis = 'H';     ///< hypothesis of an ambiguous edge; pose graphs
inline constexpr char kClosureChoice = 'R';  ///< role of a closure in a solve; closures
inline constexpr char kClosureWeight = 'S';  ///< of a switchable constraint; baselines
inline constexpr char kComponent = 'K';      ///< of a mixture without a variable of its own

}  // namespace hybrid::key_letter
