// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <string_view>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// What a file is that begins with these bytes and is no rawlog, and what to do with it: "this is a
/// pose graph: use hybrid-pgo". Empty where nothing is known against it.
std::string foreign_kind(std::string_view head);

}  // namespace hybrid
