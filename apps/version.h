// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

namespace hybrid {

/// The version of the project and, for a build of a checkout, its `git describe`: "0.1.0
/// (bf22a11)".
std::string program_version();

}  // namespace hybrid
