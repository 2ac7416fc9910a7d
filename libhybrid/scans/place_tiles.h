// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "libhybrid/scans/scan_closures.h"

namespace HYBRID_API hybrid {

/// Stored scans by squares of their map, to search for where points were seen among all of them.
/// Each square has a coarse field, from which places are proposed; fine ones are made where they
/// are needed, and some are kept.
class PlaceTiles {
 public:
  /// `map_length`: the way that stored scans span [m].
  explicit PlaceTiles(std::vector<StoredScans> stored, double map_length = 8.0);

  /// Poses in the map, at any heading, of the frame of points that are at most `kView` from its
  /// origin: those at which most of them are on surfaces, one for each place.
  std::vector<MatchMode> search(const std::vector<SurfacePoint>& points,
                                const MatchOptions& options);
  /// The best pose near one; nothing where the map does not know most of what is there.
  std::optional<ScanAlignment> align_at(const std::vector<SurfacePoint>& points, const SE2& pose);
  /// Length of the points that is on surfaces, and length that is not [m].
  std::pair<double, double> lengths_at(const std::vector<SurfacePoint>& points, const SE2& pose);

  const std::vector<StoredScans>& stored() const { return stored_; }
  /// Of what each of the stored scans show, in the map.
  const std::vector<Eigen::Vector2d>& middles() const { return middles_; }

  static constexpr double kView = 8.0;  ///< of points from where they are seen, at most [m]

 private:
  using Name = std::pair<int, int>;  // of a square: its column and row
  struct Tile {
    std::vector<std::uint8_t> coarse;  // how near cells are to surfaces
    std::vector<std::size_t> shows;    // the stored scans that can be seen from it
    std::shared_ptr<const MatchTarget> fine;
    std::size_t used = 0;
  };
  struct Proposal {
    int score = 0;
    double excess = 0.0;  // over the mean of its square
    Name tile;
    SE2 pose;  // in the map
  };

  using Tiles = std::vector<std::pair<Name, const Tile*>>;
  void draw(const Eigen::Vector2d& point, std::size_t stored);
  Tile* tile_at(const Eigen::Vector2d& position);
  const MatchTarget& fine(const Name& name);
  bool is_known(const std::vector<SurfacePoint>& points, const SE2& pose);

  std::vector<StoredScans> stored_;
  double was_near_;  // the map knows what is there if its robot was so near to there [m]
  std::vector<Eigen::Vector2d> middles_;
  std::map<Name, Tile> tiles_;
  std::size_t uses_ = 0, kept_ = 0;
};

}  // namespace hybrid
