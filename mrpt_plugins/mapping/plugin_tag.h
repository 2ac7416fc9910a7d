// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <string_view>

#include "mrpt_plugins/mapping/register_plugin.h"

namespace HYBRID_API hybrid {

/// The version tag (hybrid_plugin_abi) in the bytes of a shared library (ELF, for the processor of
/// this program), which is not loaded for it: one for another version of MRPT may crash while it
/// is. Nothing if there is none, or the file is no such library.
std::optional<PluginAbi> find_plugin_tag(std::string_view library);

}  // namespace hybrid
