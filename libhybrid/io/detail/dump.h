// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>

#include "libhybrid/hybrid/graph.h"

namespace hybrid {

/// A graph as readable text, one line per factor: its handle, name, variables and, given an
/// estimate, its cost (a hybrid factor also the component chosen). The form may change.
std::string dump(const HybridGraph& graph, const Estimate* estimate = nullptr);

/// One line per variable: name, type and value (translation [m], rotation as angle [rad] or
/// quaternion).
std::string dump(const Estimate& estimate);

}  // namespace hybrid
