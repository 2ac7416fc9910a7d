// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "libhybrid/methods/robust_methods.h"
#include "mrpt_plugins/bridge/ini_file.h"

namespace HYBRID_API hybrid {

/// Declares and reads the sections of the robust methods: [mixture], [selection],
/// [online_selection], [portfolio], [alternation], [gnc], [dcs], [switchable], [consistency]. Keys
/// that the INI lacks are as in `defaults`.
MethodOptions read_method_options(IniFile& ini, const MethodOptions& defaults = {});

}  // namespace hybrid
