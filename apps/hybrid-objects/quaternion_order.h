// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "libhybrid/objects/object_sightings.h"

namespace hybrid {

/// Whether rotations of odom.txt read as qx qy qz qw seem to be written qw qx qy qz: with the real
/// part first, the static objects stay in place much better. Cameras have no side that is up.
bool seems_real_part_first(const ObjectSequence& sequence);

}  // namespace hybrid
