// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/core/initializer.h>
#include <mrpt/version.h>

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "libhybrid/core/version.h"
#include "mrpt_plugins/mapping/mapping_plugin.h"

namespace HYBRID_API hybrid {

/// What a library with plugins and the program that loads it must agree on.
struct PluginAbi {
  std::uint32_t bytes = sizeof(PluginAbi);
  std::uint32_t version[3] = {kVersionMajor, kVersionMinor, kVersionPatch};
  std::uint32_t mrpt = MRPT_VERSION;
  std::uint32_t eigen[3] = {EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION};
  std::uint32_t alignment = EIGEN_MAX_ALIGN_BYTES;  ///< of what Eigen allocates
  std::uint32_t cxx11_strings = _GLIBCXX_USE_CXX11_ABI;
  /// Of what crosses between them, which other headers of the same version may have changed.
  std::uint32_t sizes[6] = {sizeof(MappingPlugin), sizeof(Frame),   sizeof(MapView),
                            sizeof(Contribution),  sizeof(Outcome), sizeof(Delta)};
  /// The last virtual method: its place in the table of a class tells how many there are.
  std::vector<AssociationDecision> (MappingPlugin::*last_method)(const MapView&) const =
      &MappingPlugin::decisions;
};

static_assert(sizeof(PluginAbi) == 16 * sizeof(std::uint32_t) + 2 * sizeof(void*),
              "compared byte by byte: without gaps");

/// Versions and settings in words, for messages.
std::string to_string(const PluginAbi& abi);

}  // namespace hybrid

extern "C" {
/// Stands once in every library that includes this, for the program that loads it. (An inline
/// variable would be one for the whole process.)
[[gnu::weak, gnu::visibility("default")]] extern const hybrid::PluginAbi hybrid_plugin_abi;
const hybrid::PluginAbi hybrid_plugin_abi{};
}

/// Registers a class of plugins, which derives from hybrid::MappingPlugin and says
/// DEFINE_MRPT_OBJECT(Class, Namespace). One line for each class, outside of all namespaces.
#define HYBRID_REGISTER_PLUGIN(Class, Namespace)                  \
  IMPLEMENTS_MRPT_OBJECT(Class, hybrid::MappingPlugin, Namespace) \
  MRPT_INITIALIZER(register_##Class) {                            \
    mrpt::rtti::registerClass(CLASS_ID(Namespace::Class));        \
  }
