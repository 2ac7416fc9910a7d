// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/scans/place_tiles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "libhybrid/core/evenly_chosen.h"
#include "libhybrid/core/quantile.h"

namespace hybrid {
namespace {

/// Of the coarse field: its cells, and how far from a surface they tell of it [m].
constexpr double kCell = 0.4;
constexpr double kCoarseSigma = 0.3;
/// A square is so many cells wide, a place for the robot each; its field is wider by the view.
constexpr int kCells = 40;
constexpr double kWidth = kCells * kCell;
constexpr int kMargin = int(PlaceTiles::kView / kCell) + 1;
constexpr int kFieldCells = kCells + 2 * kMargin;
/// On a surface; times the points of a proposal, this fits into a byte.
constexpr int kOnCell = 4;
constexpr std::size_t kCoarsePoints = 60;
/// Headings between which points at the end of the view move by a cell.
constexpr int kHeadings = 126;
/// Of cells and headings that are so near to each other, the best one is proposed.
constexpr int kBlock = 5;
constexpr int kHeadingBlock = 9;
/// Proposals that are looked at closely: a budget of time.
constexpr std::size_t kMostProposals = 100;
/// What a proposal may be off by [m], [rad].
constexpr double kCloseReach = 0.4;
constexpr double kCloseTurn = 0.06;
/// Fine fields that are kept, half a megabyte each.
constexpr std::size_t kMostFine = 64;
/// The map knows what is there if this share of the points has a surface within some 0.6 m.
constexpr double kKnown = 0.5;
constexpr int kIterations = 10;
/// A point lies on a surface that is so near, across it and to its next point [m].
constexpr double kIsShown = 0.1;
constexpr double kNextPoint = 0.15;
constexpr double kLeastLength = 0.1, kMostLength = 1.0;  // that a point stands for [m]

/// Where the robot was when it saw points, roughly: most of them are near its way.
Eigen::Vector2d middle_of(const std::vector<SurfacePoint>& points) {
  std::vector<double> x, y;
  for (const SurfacePoint& point : points) {
    x.push_back(point.position.x());
    y.push_back(point.position.y());
  }
  return {median(std::move(x)), median(std::move(y))};
}

Eigen::Vector2d corner_of(const std::pair<int, int>& name) {
  return kWidth * Eigen::Vector2d(name.first, name.second);
}

SE2 frame_of(const std::pair<int, int>& name) {
  const Eigen::Vector2d middle = corner_of(name) + Eigen::Vector2d::Constant(0.5 * kWidth);
  return {middle.x(), middle.y(), 0.0};
}

int square(double coordinate) {
  return static_cast<int>(std::floor(coordinate / kWidth));
}

int cell(double coordinate) {
  return static_cast<int>(std::floor(coordinate / kCell));
}

}  // namespace

PlaceTiles::PlaceTiles(std::vector<StoredScans> stored, double map_length)
    : stored_(std::move(stored)), was_near_(map_length / 2) {
  const auto is_empty = [](const StoredScans& scans) { return scans.points.empty(); };
  stored_.erase(std::remove_if(stored_.begin(), stored_.end(), is_empty), stored_.end());
  for (const StoredScans& scans : stored_) {
    const Eigen::Vector2d middle = scans.T_map_anchor.motion * middle_of(scans.points);
    middles_.push_back(middle);
    for (int x = square(middle.x() - map_length); x <= square(middle.x() + map_length); ++x) {
      for (int y = square(middle.y() - map_length); y <= square(middle.y() + map_length); ++y) {
        tiles_[{x, y}].coarse.resize(std::size_t{kFieldCells} * kFieldCells);
      }
    }
  }
  for (std::size_t m = 0; m < stored_.size(); ++m) {
    for (const SurfacePoint& point : stored_[m].points) {
      draw(stored_[m].T_map_anchor.motion * point.position, m);
    }
  }
}

/// Enters a point into the coarse fields of all squares that it can be seen from.
void PlaceTiles::draw(const Eigen::Vector2d& point, std::size_t stored) {
  constexpr double kBorder = kMargin * kCell;
  for (int x = square(point.x() - kBorder); x <= square(point.x() + kBorder); ++x) {
    for (int y = square(point.y() - kBorder); y <= square(point.y() + kBorder); ++y) {
      const auto it = tiles_.find({x, y});
      if (it == tiles_.end()) continue;
      Tile& tile = it->second;
      if (tile.shows.empty() || tile.shows.back() != stored) tile.shows.push_back(stored);
      const Eigen::Vector2d at = point - corner_of({x, y}) + Eigen::Vector2d::Constant(kBorder);
      for (int row = cell(at.y()) - 1; row <= cell(at.y()) + 1; ++row) {
        for (int column = cell(at.x()) - 1; column <= cell(at.x()) + 1; ++column) {
          if (row < 0 || column < 0 || row >= kFieldCells || column >= kFieldCells) continue;
          const Eigen::Vector2d off = kCell * Eigen::Vector2d(column + 0.5, row + 0.5) - at;
          const double s = off.squaredNorm() / (2.0 * kCoarseSigma * kCoarseSigma);
          std::uint8_t& value = tile.coarse[std::size_t(row) * kFieldCells + column];
          value = std::max(value, static_cast<std::uint8_t>(std::lround(kOnCell * std::exp(-s))));
        }
      }
    }
  }
}

PlaceTiles::Tile* PlaceTiles::tile_at(const Eigen::Vector2d& position) {
  const auto it = tiles_.find({square(position.x()), square(position.y())});
  return it == tiles_.end() ? nullptr : &it->second;
}

/// All that can be seen from a square, in its frame; kept as long as it is among those used last.
const MatchTarget& PlaceTiles::fine(const Name& name) {
  Tile& tile = tiles_.at(name);
  tile.used = ++uses_;
  if (tile.fine != nullptr) return *tile.fine;
  const SE2 T_tile_map = frame_of(name).inverse();
  std::vector<SurfacePoint> points;
  for (const std::size_t m : tile.shows) {
    for (SurfacePoint& point :
         transformed(T_tile_map * stored_[m].T_map_anchor.motion, stored_[m].points)) {
      if (point.position.cwiseAbs().maxCoeff() < 0.5 * kWidth + kView) points.push_back(point);
    }
  }
  tile.fine = std::make_shared<const MatchTarget>(make_match_target(points));
  if (++kept_ > kMostFine) {
    Tile* oldest = &tile;
    for (auto& [other, kept] : tiles_) {
      if (kept.fine != nullptr && kept.used < oldest->used) oldest = &kept;
    }
    oldest->fine.reset();
    --kept_;
  }
  return *tile.fine;
}

namespace {

/// Scores all cells of squares at all headings, by how much more than the mean of its square each
/// has: where things lie everywhere, all cells score much.
template <class Proposal, class Tiles>
std::vector<Proposal> propose_poses(const Tiles& tiles,
                                    const std::vector<Eigen::Vector2d>& points) {
  constexpr int kBlocks = kCells / kBlock;
  std::array<std::uint8_t, kCells * kCells> sums;
  std::vector<double> means(tiles.size(), 0.0);
  std::vector<Proposal> out;
  std::vector<std::size_t> squares;  // of the proposals
  for (int first = 0; first < kHeadings; first += kHeadingBlock) {
    std::vector<std::vector<int>> offsets;  // by heading, of the points in the field
    for (int h = first; h < std::min(first + kHeadingBlock, kHeadings); ++h) {
      offsets.emplace_back();
      const SO2 heading(2 * M_PI * h / kHeadings);
      for (const Eigen::Vector2d& p : points) {
        const Eigen::Vector2d q = heading * p + Eigen::Vector2d::Constant(0.5 * kCell);
        offsets.back().push_back((cell(q.y()) + kMargin) * kFieldCells + cell(q.x()) + kMargin);
      }
    }
    for (std::size_t t = 0; t < tiles.size(); ++t) {
      const auto& [name, tile] = tiles[t];
      std::array<Proposal, kBlocks * kBlocks> best{};
      for (std::size_t h = 0; h < offsets.size(); ++h) {
        sums.fill(0);
        for (const int offset : offsets[h]) {
          for (int row = 0; row < kCells; ++row) {
            const std::uint8_t* from = tile->coarse.data() + offset + row * kFieldCells;
            std::uint8_t* to = sums.data() + row * kCells;
            for (int column = 0; column < kCells; ++column) to[column] += from[column];
          }
        }
        means[t] += std::accumulate(sums.begin(), sums.end(), 0.0) / (kCells * kCells * kHeadings);
        for (int c = 0; c < kCells * kCells; ++c) {
          const int column = c % kCells, row = c / kCells;
          Proposal& block = best[row / kBlock * kBlocks + column / kBlock];
          if (sums[c] <= block.score) continue;
          const Eigen::Vector2d at =
              corner_of(name) + kCell * Eigen::Vector2d(column + 0.5, row + 0.5);
          block = {sums[c], 0.0, name, SE2(at, SO2(2 * M_PI * (first + double(h)) / kHeadings))};
        }
      }
      for (const Proposal& proposal : best) {
        if (proposal.score <= 0) continue;
        out.push_back(proposal);
        squares.push_back(t);
      }
    }
  }
  for (std::size_t i = 0; i < out.size(); ++i) out[i].excess = out[i].score - means[squares[i]];
  return out;
}

}  // namespace

std::vector<MatchMode> PlaceTiles::search(const std::vector<SurfacePoint>& points,
                                          const MatchOptions& options) {
  Tiles tiles;
  for (const auto& [name, tile] : tiles_) tiles.emplace_back(name, &tile);
  const auto used = evenly_chosen(positions_of(points), kCoarsePoints);
  auto proposals = propose_poses<Proposal>(tiles, used);
  std::stable_sort(proposals.begin(), proposals.end(),
                   [](const Proposal& a, const Proposal& b) { return a.excess > b.excess; });
  const double least = options.search.min_score * kOnCell * double(used.size());
  std::vector<MatchMode> out;
  for (std::size_t i = 0; i < std::min(proposals.size(), kMostProposals); ++i) {
    const Proposal& proposal = proposals[i];
    if (proposal.score < least) continue;
    const SE2 T_map_tile = frame_of(proposal.tile);
    const SearchWindow window{T_map_tile.inverse() * proposal.pose,
                              Eigen::Vector2d::Constant(kCloseReach), kCloseTurn};
    for (MatchMode& mode : match(points, fine(proposal.tile), window, options)) {
      mode.pose.motion = T_map_tile * mode.pose.motion;
      out.push_back(mode);
    }
  }
  return out;
}

bool PlaceTiles::is_known(const std::vector<SurfacePoint>& points, const SE2& pose) {
  const Tile* tile = tile_at(pose.translation());
  const bool was_near =
      std::any_of(middles_.begin(), middles_.end(), [&](const Eigen::Vector2d& middle) {
        return (middle - pose.translation()).norm() < was_near_;
      });
  if (tile == nullptr || !was_near) return false;
  const Eigen::Vector2d corner = corner_of({square(pose.x()), square(pose.y())});
  std::size_t near = 0;
  for (const SurfacePoint& point : points) {
    const Eigen::Vector2d at = pose * point.position - corner;
    const int column = cell(at.x()) + kMargin, row = cell(at.y()) + kMargin;
    if (row < 0 || column < 0 || row >= kFieldCells || column >= kFieldCells) continue;
    if (tile->coarse[std::size_t(row) * kFieldCells + column] > 0) ++near;
  }
  return double(near) >= kKnown * double(points.size());
}

std::optional<ScanAlignment> PlaceTiles::align_at(const std::vector<SurfacePoint>& points,
                                                  const SE2& pose) {
  if (points.empty() || !is_known(points, pose)) return std::nullopt;
  const Name name{square(pose.x()), square(pose.y())};
  const SE2 T_map_tile = frame_of(name);
  AlignmentOptions options;
  options.max_iterations = kIterations;
  ScanAlignment found = align(points, fine(name).surfaces, T_map_tile.inverse() * pose, options);
  found.pose = T_map_tile * found.pose;
  return found;
}

std::pair<double, double> PlaceTiles::lengths_at(const std::vector<SurfacePoint>& points,
                                                 const SE2& pose) {
  std::pair<double, double> out{0.0, 0.0};
  if (tile_at(pose.translation()) == nullptr) return out;
  const Name name{square(pose.x()), square(pose.y())};
  const SurfaceMap& surfaces = fine(name).surfaces;
  for (const SurfacePoint& point : transformed(frame_of(name).inverse() * pose, points)) {
    const double length = std::clamp(point.length, kLeastLength, kMostLength);
    const SurfaceMap::Surfel* surfel = surfaces.nearest(point.position, point.normal, kNextPoint);
    const bool on = surfel != nullptr &&
                    std::abs(surfel->normal.dot(point.position - surfel->position)) < kIsShown;
    (on ? out.first : out.second) += length;
  }
  return out;
}

}  // namespace hybrid
