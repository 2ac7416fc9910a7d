// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/core/Clock.h>
#include <mrpt/version.h>

#include <cstdint>
#include <type_traits>

#include "libhybrid/export.h"

// All that differs between MRPT 2.5 and MRPT 3 in what this project uses. The CMake variable
// HYBRID_MRPT chooses the version and with it the packages that are found.

/// RTTI of an abstract class.
#if MRPT_VERSION >= 0x20e00  // as of 2.14, that of Debian 13
#define HYBRID_DEFINE_VIRTUAL_MRPT_OBJECT(Class, Namespace) \
  DEFINE_VIRTUAL_MRPT_OBJECT(Class, Namespace)
#else
#define HYBRID_DEFINE_VIRTUAL_MRPT_OBJECT(Class, Namespace) DEFINE_VIRTUAL_MRPT_OBJECT(Class)
#endif

#if MRPT_VERSION >= 0x30000

/// The header of a class of scenes, for #include.
// NOLINTNEXTLINE(bugprone-macro-parentheses): the name of a header
#define HYBRID_MRPT_SCENE(name) <mrpt/viz/name.h>
/// Name of the class of whole scenes, without namespace, and of its header.
#define HYBRID_MRPT_SCENE_CLASS Scene
/// Overrides mrpt::obs::CObservation::getSensorPose() with a member or expression.
#define HYBRID_DEFINE_SENSOR_POSE(value)                \
  mrpt::poses::CPose3D getSensorPose() const override { \
    return value;                                       \
  }

namespace mrpt::viz {}
namespace HYBRID_API hybrid {
namespace mrpt_scene = mrpt::viz;

/// Sets the one light of a viewport: strength of what is lit from all sides, diffusely and shining,
/// from 0 to 1, and the direction in which it shines. MRPT 2.5 draws neither what shines nor with
/// gamma correction: colours would be paler.
template <class LightParameters, class Direction>
void set_light(LightParameters& parameters, float ambient, float diffuse, float,
               const Direction& direction) {
  parameters.ambient = ambient;
  parameters.lights.resize(1);
  parameters.lights[0].diffuse = diffuse;
  parameters.lights[0].specular = 0;
  parameters.lights[0].direction = direction;
  parameters.gamma_correction = false;
}

/// Lets a map of points keep those that later scans see through, as MRPT 3 always does.
template <class InsertionOptions>
void keep_all_points(InsertionOptions&) {}

/// Sets the camera of a CFBORender.
template <class Renderer, class Scene, class Camera>
void set_camera(Renderer& renderer, const Scene&, const Camera& camera) {
  renderer.setCamera(camera);
}

}  // namespace hybrid

#else

// NOLINTNEXTLINE(bugprone-macro-parentheses): the name of a header
#define HYBRID_MRPT_SCENE(name) <mrpt/opengl/name.h>
#define HYBRID_MRPT_SCENE_CLASS COpenGLScene
#define HYBRID_DEFINE_SENSOR_POSE(value)                          \
  void getSensorPose(mrpt::poses::CPose3D& pose) const override { \
    pose = value;                                                 \
  }

namespace mrpt::opengl {}
namespace HYBRID_API hybrid {
namespace mrpt_scene = mrpt::opengl;

/// A strength of light, a grey in MRPT 2.5 and a number in 2.14.
template <class Strength>
Strength strength_of_light(const Strength&, float value) {
  if constexpr (std::is_arithmetic_v<Strength>) {
    return value;
  } else {
    return {value, value, value, 1};
  }
}

template <class LightParameters, class Direction>
void set_light(LightParameters& parameters, float ambient, float diffuse, float specular,
               const Direction& direction) {
  parameters.ambient = strength_of_light(parameters.ambient, ambient);
  parameters.diffuse = strength_of_light(parameters.diffuse, diffuse);
  parameters.specular = strength_of_light(parameters.specular, specular);
  parameters.direction = direction;
}

template <class InsertionOptions>
void keep_all_points(InsertionOptions& options) {
  options.disableDeletion = true;
}

template <class Renderer, class Scene, class Camera>
void set_camera(Renderer& renderer, const Scene& scene, const Camera& camera) {
  renderer.setCamera(scene, camera);
}

}  // namespace hybrid

#endif

namespace HYBRID_API hybrid {

/// Seconds since 1970 of a time stamp, 0 if it is invalid: what mrpt::Clock::toDouble() of MRPT 2.5
/// returns. That of MRPT 3 rounds the time since 1601, whose ticks of 100 ns have more digits than
/// a double, by up to 0.8 microseconds.
inline double seconds_of(mrpt::Clock::time_point stamp) {
  if (stamp == mrpt::Clock::time_point()) return 0;
  constexpr std::int64_t kTicksPerSecond = 10'000'000;
  constexpr std::int64_t kFrom1601To1970 = 11'644'473'600 * kTicksPerSecond;
  const auto ticks = static_cast<std::int64_t>(stamp.time_since_epoch().count()) - kFrom1601To1970;
  return static_cast<double>(ticks) / kTicksPerSecond;
}

}  // namespace hybrid
