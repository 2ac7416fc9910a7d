// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Ranges to beacons, some without identity (the Plaza logs with ambiguous association): each of
// these is a mixture over the beacons, as a max-mixture or a sum-mixture.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/factors/range.h"
#include "libhybrid/hybrid/soft_mixture.h"
#include "libhybrid/solvers/alternating.h"

namespace hybrid {
namespace {

using Eigen::Vector2d;
using BeaconRange = Range<SE2, Vector2d>;

struct RangeRow {
  int pose = 0;
  std::vector<int> beacons;  ///< one, or the candidates
  double range = 0, sigma = 0;
};

struct PlazaLog {
  std::map<int, SE2> truth;
  std::map<int, Vector2d> beacons;
  std::vector<SE2> motions;
  std::vector<Noise> motion_noise;
  SE2 first;
  std::vector<RangeRow> ranges;
};

int index_of(const std::string& name) {
  return std::stoi(name.substr(1));
}

template <int N>
Eigen::Matrix<double, N, 1> numbers(std::istringstream& words) {
  Eigen::Matrix<double, N, 1> v;
  for (double& x : v) words >> x;
  return v;
}

/// The words between two keywords.
std::vector<std::string> until(std::istringstream& words, const std::string& end) {
  std::vector<std::string> out;
  for (std::string word; words >> word && word != end;) out.push_back(word);
  return out;
}

void read_factor(std::istringstream& words, PlazaLog& log) {
  std::string kind, word;
  words >> kind;
  if (kind == "UnarySE2ApproximateGaussianPriorFactor") {
    words >> word;
    const Eigen::Vector3d v = numbers<3>(words);
    log.first = SE2(v[0], v[1], v[2]);
  } else if (kind == "SE2RelativeGaussianLikelihoodFactor") {
    words >> word >> word;
    const Eigen::Vector3d v = numbers<3>(words);
    words >> word;
    const auto c = numbers<9>(words);
    log.motions.emplace_back(v[0], v[1], v[2]);
    const Eigen::Matrix3d C = Eigen::Map<const Eigen::Matrix3d>(c.data());
    log.motion_noise.push_back(Noise::covariance(0.5 * (C + C.transpose())));
  } else if (kind == "SE2R2RangeGaussianLikelihoodFactor") {
    RangeRow row;
    words >> word;
    row.pose = index_of(word);
    words >> word;
    row.beacons = {index_of(word)};
    words >> row.range >> row.sigma;
    log.ranges.push_back(row);
  } else if (kind == "AmbiguousDataAssociationFactor") {
    RangeRow row;
    words >> word >> word;
    row.pose = index_of(word);
    words >> word;
    for (const std::string& name : until(words, "Weights")) row.beacons.push_back(index_of(name));
    until(words, "Observation");
    words >> row.range >> word >> row.sigma;
    log.ranges.push_back(row);
  } else {
    throw Error("unknown factor " + kind);
  }
  if (words.fail()) throw Error("a row of kind " + kind + " is not complete");
}

PlazaLog read_log(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw Error("cannot read " + path);
  PlazaLog log;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string what, kind, space, name;
    if (!(words >> what)) continue;
    if (what == "Factor") {
      read_factor(words, log);
      continue;
    }
    words >> kind >> space >> name;
    if (kind == "Pose") {
      const Eigen::Vector3d v = numbers<3>(words);
      log.truth[index_of(name)] = SE2(v[0], v[1], v[2]);
    } else {
      log.beacons[index_of(name)] = numbers<2>(words);
    }
  }
  return log;
}

Key beacon_key(int i) {
  return {'l', static_cast<std::uint64_t>(i)};
}

/// Dead reckoning, and each beacon at the grid point that fits its identified ranges best.
Values start_values(const PlazaLog& log) {
  Values values;
  std::vector<SE2> path = {log.first};
  for (const SE2& motion : log.motions) path.push_back(path.back() * motion);
  for (std::size_t i = 0; i < path.size(); ++i) values.insert(Key('x', i), path[i]);
  for (const auto& [id, truth] : log.beacons) {
    double best = std::numeric_limits<double>::infinity();
    Vector2d at(0, 0);
    for (double x = -100; x <= 100; x += 2) {
      for (double y = -100; y <= 100; y += 2) {
        double sum = 0;
        for (const RangeRow& row : log.ranges) {
          if (row.beacons.size() > 1 || row.beacons[0] != id) continue;
          const Vector2d d =
              path[static_cast<std::size_t>(row.pose)].translation() - Vector2d(x, y);
          sum += std::abs(d.norm() - row.range);
        }
        if (sum < best) best = sum, at = Vector2d(x, y);
      }
    }
    values.insert(beacon_key(id), at);
  }
  return values;
}

enum class Meaning { kChosen, kSummed, kLeftOut };

HybridGraph make_graph(const PlazaLog& log, Meaning meaning) {
  HybridGraph graph;
  graph.emplace<Prior<SE2>>(Key('x', 0), log.first, Noise::isotropic(3, 1e-3));
  for (std::size_t i = 0; i < log.motions.size(); ++i) {
    graph.emplace<BetweenSE2>(Key('x', i), Key('x', i + 1), log.motions[i], log.motion_noise[i]);
  }
  for (std::size_t k = 0; k < log.ranges.size(); ++k) {
    const RangeRow& row = log.ranges[k];
    std::vector<MixtureComponent> components;
    for (int id : row.beacons) {
      components.push_back(
          {std::make_shared<BeaconRange>(Key('x', static_cast<std::uint64_t>(row.pose)),
                                         beacon_key(id), row.range, Noise::isotropic(1, row.sigma)),
           std::log(static_cast<double>(row.beacons.size()))});
    }
    if (components.size() == 1) {
      graph.add(components[0].factor);
    } else if (meaning == Meaning::kChosen) {
      const DiscreteKey which{Key('d', k), static_cast<int>(components.size())};
      graph.add(std::make_shared<Mixture>(std::vector<DiscreteKey>{which}, std::move(components)));
    } else if (meaning == Meaning::kSummed) {
      graph.emplace<SoftMixture>(std::move(components));
    }
  }
  return graph;
}

/// Mean distance of the poses after rigid alignment [m].
double path_error(const PlazaLog& log, const Values& values) {
  Eigen::Matrix2Xd a(2, log.truth.size()), b(2, log.truth.size());
  Eigen::Index i = 0;
  for (const auto& [index, pose] : log.truth) {
    a.col(i) = values.at<SE2>(Key('x', static_cast<std::uint64_t>(index))).translation();
    b.col(i++) = pose.translation();
  }
  const Eigen::Matrix3d T = Eigen::umeyama(a, b, false);
  return ((T.topLeftCorner<2, 2>() * a).colwise() + T.col(2).head<2>() - b).colwise().norm().mean();
}

void run(const std::string& path) {
  const PlazaLog log = read_log(path);
  const Values start = start_values(log);
  Estimate initial{start, {}};
  for (std::size_t k = 0; k < log.ranges.size(); ++k) initial.assignment.set(Key('d', k), 0);
  const auto ambiguous = std::count_if(log.ranges.begin(), log.ranges.end(),
                                       [](const RangeRow& r) { return r.beacons.size() > 1; });
  std::printf("%s: %zu poses, %zu ranges, %td ambiguous, dead reckoning %.3f m\n",
              path.substr(path.rfind('/') + 1).c_str(), log.truth.size(), log.ranges.size(),
              ambiguous, path_error(log, start));
  const std::pair<const char*, Meaning> methods[] = {{"left out", Meaning::kLeftOut},
                                                     {"max-mixture", Meaning::kChosen},
                                                     {"sum-mixture", Meaning::kSummed}};
  for (const auto& [name, meaning] : methods) {
    const HybridGraph graph = make_graph(log, meaning);
    const std::clock_t before = std::clock();
    const AlternatingResult result = alternate(graph, initial);
    std::printf("  %-12s path %.3f m  objective %.2f  %.3f s\n", name,
                path_error(log, result.estimate.values), result.report.objective,
                double(std::clock() - before) / CLOCKS_PER_SEC);
  }
}

}  // namespace
}  // namespace hybrid

int main(int argc, char** argv) try {
  if (argc < 2) {
    std::fprintf(stderr, "usage: bench-plaza LOG.fg...\n");
    return EXIT_FAILURE;
  }
  for (int i = 1; i < argc; ++i) hybrid::run(argv[i]);
  return EXIT_SUCCESS;
} catch (const std::exception& e) {
  std::fprintf(stderr, "bench-plaza: %s\n", e.what());
  return EXIT_FAILURE;
}
