// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "mrpt_plugins/import/log_writer.h"

namespace HYBRID_API hybrid {

/// CMU Plaza (Djugash): a mower that measures its distance to radio beacons, as a factor graph in
/// the text form of NF-iSAM (Huang et al. 2021).
struct PlazaOptions {
  std::string graph;  ///< F.fg
  /// The same graph with all identities known (p = 0), which tells the true beacons of ambiguous
  /// ranges; empty: not known.
  std::string identities;
  /// Factor of the standard deviations of the translation of motions, which are off by twice
  /// what the graph states.
  double inflate = 2;
  double period = 1;  ///< Between poses, for which the graph has no time [s].
};

/// Converts a graph into a planar log with a step for each pose and a CObservationBeaconRanges with
/// its ranges. A range that may be to several beacons is one to an unknown beacon
/// (INVALID_BEACON_ID). The values of the variables in the graph are the truth.
ImportReport import_plaza(const PlazaOptions& options, const std::string& output);

}  // namespace hybrid
