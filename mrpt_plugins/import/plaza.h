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
  /// The same graph with all identities known (p = 0), which has the true beacons of ambiguous
  /// ranges; empty: unknown.
  std::string identities;
  /// Factor of the translational sigmas of motions: their errors are twice the stated sigmas.
  double inflate = 2;
  double period = 1;  ///< Time between poses [s]; the graph has no times.
};

/// Converts a graph into a planar log with one step per pose and a CObservationBeaconRanges with
/// its ranges. An ambiguous range has an unknown beacon (INVALID_BEACON_ID). The values of the
/// variables in the graph are the ground truth.
ImportReport import_plaza(const PlazaOptions& options, const std::string& output);

}  // namespace hybrid
