// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

namespace hybrid {

/// The version of the project and, where it was built from a checkout, what `git describe` says of
/// that: "0.1.0 (bf22a11)".
std::string program_version();

}  // namespace hybrid
