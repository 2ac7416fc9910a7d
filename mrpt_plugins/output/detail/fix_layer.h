// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "mrpt_plugins/drawing/axes.h"
#include "mrpt_plugins/output/detail/legend.h"

namespace hybrid {

/// Fixes of satellite receivers in a plan that shows `box`: where the receiver says that it is, and
/// of biased and false ones a line to where the map says so.
void draw_fixes(Canvas& canvas, const Axes& axes, const Box& box, const MapResult& result);

/// Entries of those that `box` shows, with counts of all.
void fix_legend(Legend& legend, const Axes& axes, const Box& box, const MapResult& result);

}  // namespace hybrid
