// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/maps/join_maps.h"
#include "libhybrid/online/join_graph.h"
#include "libhybrid/scans/scan_place.h"

namespace HYBRID_API hybrid {

/// The laser scans of a map, by its local maps.
std::vector<StoredScans> stored_scans(const MapRecord& map);

/// Where the scans of one map are among those of another, if they are.
struct ScanJoin {
  std::string why;  ///< where they are not found: what speaks against it, else empty
  UncertainMotion T_first_second;
  /// Of all scans, those of the first map first, in its frame, as the matches place them.
  std::vector<KnownPlace<SE2>> anchors;
  std::size_t matches = 0;   ///< of scans of both, that were found at the place
  std::size_t accepted = 0;  ///< those that are right
  double log_odds = 0.0;     ///< of the place to chance

  bool is_found() const { return why.empty(); }
};

/// Searches a place of the second map in the first: its local maps, of those that overlap every
/// second one, are stretches that a ScanPlaceSearch looks for, until a place stands out. From
/// there, local maps of both are matched in windows that shrink as the place becomes known,
/// OnlineSelection decides which matches are right, and all local maps are estimated together.
ScanJoin join_scans(const std::vector<StoredScans>& first, const std::vector<StoredScans>& second,
                    const ScanPlaceOptions& options);

/// Where local maps of one robot are in those of another, of which it is roughly known where its
/// frame is: matches that agree with each other.
std::vector<PlaceMatch<SE2>> common_places(const std::vector<StoredScans>& first,
                                           const std::vector<StoredScans>& second,
                                           const UncertainMotion& T_first_second);

/// Joins two maps in the plane by the laser scans that both have. Landmarks that lie together then
/// are one. Nothing where no place stands out with these `odds`; `why` tells what speaks against
/// it. Throws Error as join_maps().
std::optional<JoinedMaps> join_maps_by_scans(const MapRecord& first, const MapRecord& second,
                                             double odds, std::string& why);

}  // namespace hybrid
