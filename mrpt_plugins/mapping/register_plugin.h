// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/version.h>

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "libhybrid/core/version.h"
#include "mrpt_plugins/mapping/mapping_plugin.h"

namespace HYBRID_API hybrid {

/// Build settings that must be equal in a plugin library and the program that loads it.
struct PluginAbi {
  std::uint32_t bytes = sizeof(PluginAbi);
  std::uint32_t version[3] = {kVersionMajor, kVersionMinor, kVersionPatch};
  std::uint32_t mrpt = MRPT_VERSION;
  std::uint32_t eigen[3] = {EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION};
  std::uint32_t alignment = EIGEN_MAX_ALIGN_BYTES;  ///< of Eigen's allocations
  std::uint32_t cxx11_strings = _GLIBCXX_USE_CXX11_ABI;
  /// Sizes of the interface types, which may differ between headers of one version.
  std::uint32_t sizes[6] = {sizeof(MappingPlugin), sizeof(Frame),   sizeof(MapView),
                            sizeof(Contribution),  sizeof(Outcome), sizeof(Delta)};
  /// The last virtual method: its position in the virtual table is the number of methods.
  std::vector<AssociationDecision> (MappingPlugin::*last_method)(const MapView&) const =
      &MappingPlugin::decisions;
};

static_assert(sizeof(PluginAbi) == 16 * sizeof(std::uint32_t) + 2 * sizeof(void*),
              "compared byte by byte: without gaps");

/// Versions and settings as text for messages.
std::string to_string(const PluginAbi& abi);

}  // namespace hybrid

extern "C" {
/// Defined once in every library that includes this header, for the program that loads it. (An
/// inline variable would be shared by the whole process.)
[[gnu::weak, gnu::visibility("default")]] extern const hybrid::PluginAbi hybrid_plugin_abi;
const hybrid::PluginAbi hybrid_plugin_abi{};
}

/// Registers a plugin class, which derives from hybrid::MappingPlugin and contains
/// DEFINE_MRPT_OBJECT(Class, Namespace). One line for each class, outside of all namespaces. (A
/// variable is initialised behind the class in its file; a function that is called when the library
/// is loaded, as MRPT_INITIALIZER defines, may come before.)
#define HYBRID_REGISTER_PLUGIN(Class, Namespace)                  \
  IMPLEMENTS_MRPT_OBJECT(Class, hybrid::MappingPlugin, Namespace) \
  [[maybe_unused]] static const bool is_registered_##Class =      \
      (mrpt::rtti::registerClass(CLASS_ID(Namespace::Class)), true);
