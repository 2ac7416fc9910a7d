// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A library with the tag of this version and no plugin.

#include "mrpt_plugins/mapping/register_plugin.h"
