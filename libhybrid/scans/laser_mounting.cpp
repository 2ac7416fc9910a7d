// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/laser_mounting.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <utility>

#include "libhybrid/core/evenly_chosen.h"
#include "libhybrid/core/quantile.h"
#include "libhybrid/geometry/so2.h"
#include "libhybrid/scans/scan_tracker.h"

namespace hybrid {
namespace {

/// Scans that are compared for the field of view are so far apart [m]: what is wrong by a share of
/// it then shows as that share of the distance. So many pairs are compared, and fewer tell nothing.
constexpr double kPairDistance = 0.7;
constexpr std::size_t kMostPairs = 60, kFewestPairs = 10;
/// Fields of view to that stated of which one is tried first: of drivers that take a whole degree
/// for half a one, or 180 degrees for 90, 240, 270 or 360.
constexpr std::array<double, 7> kWidenings{1, 0.5, 2, 2.0 / 3, 1.5, 0.75, 4.0 / 3};
/// Then others around it, these apart; what is off by less than one step does no harm.
constexpr double kStep = 0.02;
constexpr int kSteps = 5;
/// A match is none below this share of points on surfaces.
constexpr double kMatched = 0.3;
/// Motions that are compared with odometry [m], [rad]; how much turning that needs [rad], and the
/// share of it that is the other way round if the rays are.
constexpr double kComparedDistance = 0.3, kComparedTurn = 0.2;
constexpr double kFewestTurns = 3, kOtherWay = 0.8;
/// Odometry of which matches differ by more of its turns is not that of this robot.
constexpr double kMostApart = 0.5;
/// What of a mounting is worth correcting: two cells of a map, and what moves a return by one at 3
/// m [m], [rad].
constexpr double kWorthMoving = 0.1, kWorthTurning = 0.02;
constexpr double kSigmas = 3;
constexpr int kTenthsOfLog = 10;

using Scans = std::vector<MovedScan>;

/// Where scans are by matches alone; those of one chain in one frame.
struct FollowedScan {
  SE2 pose;
  int chain = 0;
};

std::vector<FollowedScan> follow(const Scans& scans, const LaserMounting& mounting) {
  ScanTracker tracker;
  std::vector<SE2> keyframes;
  std::vector<FollowedScan> out;
  int chain = 0;
  for (const MovedScan& scan : scans) {
    const TrackedScan tracked =
        tracker.track(scan_points(corrected(scan.scan, mounting)), std::nullopt);
    if (tracked.is_keyframe) {
      const KeyframeMotion& motion = tracked.match ? *tracked.match : tracked.odometry;
      keyframes.push_back(keyframes.empty() ? SE2()
                                            : keyframes[motion.from] * motion.measured.motion);
    }
    if (tracked.inliers < kMatched) ++chain;
    out.push_back({keyframes[tracked.keyframe] * tracked.T_keyframe_scan, chain});
  }
  return out;
}

struct ScanPair {
  std::size_t first = 0, second = 0;
  SE2 motion;
};

/// Pairs some way apart, evenly over all scans.
std::vector<ScanPair> pairs_of(const std::vector<FollowedScan>& path) {
  std::vector<ScanPair> all;
  for (std::size_t i = 0; i < path.size(); ++i) {
    std::size_t j = i + 1;
    const auto motion = [&] { return path[i].pose.between(path[j].pose); };
    while (j < path.size() && path[j].chain == path[i].chain &&
           motion().translation().norm() < kPairDistance) {
      ++j;
    }
    if (j < path.size() && path[j].chain == path[i].chain) all.push_back({i, j, motion()});
  }
  return evenly_chosen(all, kMostPairs);
}

/// How well each pair agrees under a field of view: 0 not at all, 1 exactly.
Eigen::ArrayXd agreement(const Scans& scans, const std::vector<ScanPair>& pairs, double widening) {
  LaserMounting mounting;
  mounting.widening = widening;
  const AlignmentOptions options;
  Eigen::ArrayXd out(static_cast<Eigen::Index>(pairs.size()));
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const ScanPair& pair = pairs[k];
    const auto points = scan_points(corrected(scans[pair.second].scan, mounting));
    const SurfaceMap map(scan_points(corrected(scans[pair.first].scan, mounting)));
    const SE2 start(pair.motion.x(), pair.motion.y(), widening * pair.motion.angle());
    double all = 1e-9;
    for (const SurfacePoint& point : points) {
      all += std::min(1.0, point.length / options.correlation_length);
    }
    out[static_cast<Eigen::Index>(k)] = align(points, map, start, options).support / all;
  }
  return out;
}

/// By how many standard deviations one agrees better than the other.
double sigmas_better(const Eigen::ArrayXd& a, const Eigen::ArrayXd& b) {
  const Eigen::ArrayXd d = a - b;
  const double variance = (d - d.mean()).square().sum() / double(d.size() - 1);
  return variance > 0 ? d.mean() / std::sqrt(variance / double(d.size())) : 0;
}

/// The place of the top of a parabola through five values at -2 to 2, by least squares.
double vertex(const std::array<double, 5>& y) {
  const double slope = (-2 * y[0] - y[1] + y[3] + 2 * y[4]) / 10;
  const double bend = (2 * y[0] - y[1] - 2 * y[2] - y[3] + 2 * y[4]) / 14;
  return bend < 0 ? std::clamp(-0.5 * slope / bend, -2.0, 2.0) : 0;
}

double mean_without(const Eigen::ArrayXd& all, int tenth) {
  const Eigen::Index from = all.size() * tenth / kTenthsOfLog;
  const Eigen::Index to = all.size() * (tenth + 1) / kTenthsOfLog;
  return (all.sum() - all.segment(from, to - from).sum()) / double(all.size() - (to - from));
}

/// Standard deviation of what ten values say, each of all but a tenth of the log.
double jackknife(const Eigen::Array<double, kTenthsOfLog, 1>& without) {
  return std::sqrt((kTenthsOfLog - 1) * (without - without.mean()).square().mean());
}

double opening(const LaserScan& scan) {
  return std::abs(scan.angle_step) * (double(scan.ranges.size()) - 1);
}

using Agreement = std::function<Eigen::ArrayXd(double widening)>;

/// The best of the widenings that are tried first: that stated, unless another is clearly better.
double first_widening(const Agreement& at, double most) {
  const Eigen::ArrayXd stated = at(1);
  double first = 1, best = stated.mean();
  for (const double widening : kWidenings) {
    if (widening == 1 || widening > most) continue;
    const Eigen::ArrayXd other = at(widening);
    if (other.mean() <= best || sigmas_better(other, stated) <= kSigmas) continue;
    best = other.mean();
    first = widening;
  }
  return first;
}

void measure_widening(const Scans& scans, const std::vector<FollowedScan>& path,
                      LaserMounting& out) {
  const std::vector<ScanPair> pairs = pairs_of(path);
  if (pairs.size() < kFewestPairs) {
    out.unknown = "field of view: too few scans that agree from places apart";
    return;
  }
  const Agreement at = [&](double widening) { return agreement(scans, pairs, widening); };
  const double most = 2 * M_PI / std::max(opening(scans.front().scan), 1e-3) + 1e-3;
  const double first = first_widening(at, most);
  std::vector<Eigen::ArrayXd> near;
  std::size_t highest = 0;
  for (int k = -kSteps; k <= kSteps; ++k) {
    near.push_back(at(first * (1 + kStep * k)));
    if (near.back().mean() > near[highest].mean()) highest = near.size() - 1;
  }
  const std::size_t h = std::clamp<std::size_t>(highest, 2, 2 * kSteps - 2);
  const auto place = [&](const auto& mean) {
    const double beyond = vertex({mean(near[h - 2]), mean(near[h - 1]), mean(near[h]),
                                  mean(near[h + 1]), mean(near[h + 2])});
    return first * (1 + kStep * (double(h) - kSteps + beyond));
  };
  const double found = place([](const Eigen::ArrayXd& a) { return a.mean(); });
  Eigen::Array<double, kTenthsOfLog, 1> without;
  for (int t = 0; t < kTenthsOfLog; ++t) {
    without[t] = place([t](const Eigen::ArrayXd& a) { return mean_without(a, t); });
  }
  out.widening_sigma = jackknife(without);
  const bool is_other = std::abs(found / first - 1) > kStep &&
                        std::abs(found - first) > kSigmas * out.widening_sigma &&
                        sigmas_better(at(found), near[kSteps]) > kSigmas;
  out.widening = is_other ? found : first;
}

/// A motion by matches and the same by odometry.
struct ComparedMotion {
  SE2 match, odometry;
};

std::vector<ComparedMotion> compared(const Scans& scans, const std::vector<FollowedScan>& path) {
  std::vector<ComparedMotion> out;
  SE2 odometry;
  std::size_t from = 0;
  for (std::size_t i = 1; i < scans.size(); ++i) {
    if (!scans[i].motion || path[i].chain != path[from].chain) {
      from = i;
      odometry = SE2();
      continue;
    }
    odometry = odometry * *scans[i].motion;
    const SE2 match = path[from].pose.between(path[i].pose);
    if (match.translation().norm() < kComparedDistance && std::abs(match.angle()) < kComparedTurn)
      continue;
    out.push_back({match, odometry});
    from = i;
    odometry = SE2();
  }
  return out;
}

/// Turns of the odometry, those of them that matches have the other way, and by how much both
/// differ the way that most go [rad].
struct Turns {
  double all = 0, other = 0, apart = 0;
};

Turns turns_of(const std::vector<ComparedMotion>& motions) {
  Turns out;
  double against = 0;
  for (const ComparedMotion& motion : motions) {
    const double match = motion.match.angle(), odometry = motion.odometry.angle();
    out.all += std::abs(odometry);
    out.apart += std::abs(match - odometry);
    against += std::abs(match + odometry);
    if (match * odometry < 0) out.other += std::abs(odometry);
  }
  out.apart = std::min(out.apart, against);
  return out;
}

/// Turn and scale of the motion by odometry, as (a, b), and the place of the frame in its own.
using Frame = Eigen::Vector4d;

/// The frame whose motions are those of the matches where the robot moves as odometry says: t_match
/// = [a b; -b a] t_odometry + (R - 1) place. Robust (Cauchy), without a tenth of the motions.
Frame fit(const std::vector<ComparedMotion>& motions, int without) {
  Frame frame(1, 0, 0, 0);
  double scale = kComparedDistance;
  for (int round = 0; round < 10; ++round) {
    Eigen::Matrix4d H = Eigen::Matrix4d::Identity();  // nothing is farther off than a metre
    Eigen::Vector4d g(1, 0, 0, 0);
    std::vector<double> sizes;
    for (std::size_t i = 0; i < motions.size(); ++i) {
      if (static_cast<int>(i * kTenthsOfLog / motions.size()) == without) continue;
      const Eigen::Vector2d& t = motions[i].odometry.translation();
      Eigen::Matrix<double, 2, 4> J;
      J.leftCols<2>() << t.x(), t.y(), t.y(), -t.x();
      J.rightCols<2>() = motions[i].match.rotation().matrix() - Eigen::Matrix2d::Identity();
      const Eigen::Vector2d& z = motions[i].match.translation();
      const double size = (J * frame - z).norm();
      sizes.push_back(size);
      const double weight = 1 / (scale * scale + size * size);
      H += weight * J.transpose() * J;
      g += weight * J.transpose() * z;
    }
    frame = H.ldlt().solve(g);
    scale = std::max(1e-3, median(std::move(sizes)));
  }
  return frame;
}

/// x, y, angle of the frame.
Eigen::Vector3d place_of(const Frame& frame) {
  const SO2 turn(std::atan2(frame[1], frame[0]));
  const Eigen::Vector2d at = turn * Eigen::Vector2d(frame[2], frame[3]);
  return {at.x(), at.y(), turn.angle()};
}

void measure_place(const Scans& scans, const std::vector<FollowedScan>& path, LaserMounting& out) {
  std::vector<ComparedMotion> motions = compared(scans, path);
  const Turns turns = turns_of(motions);
  const bool is_still = turns.all < kFewestTurns || motions.size() < 2 * kTenthsOfLog;
  if (is_still || turns.apart > kMostApart * turns.all) {
    if (!out.unknown.empty()) return;
    out.unknown = is_still ? "sense of rotation and place: the robot hardly turns by odometry"
                           : "sense of rotation and place: scans and odometry tell other turns";
    return;
  }
  out.mirrored = turns.other > kOtherWay * turns.all;
  if (out.mirrored) motions = compared(scans, follow(scans, out));
  const Eigen::Vector3d place = place_of(fit(motions, -1));
  Eigen::Matrix<double, kTenthsOfLog, 3> without;
  for (int t = 0; t < kTenthsOfLog; ++t) {
    const Eigen::Vector3d other = place_of(fit(motions, t)) - place;
    without.row(t) << other.x(), other.y(), wrap_angle(other.z());
  }
  for (int i = 0; i < 3; ++i) out.sigmas[i] = jackknife(without.col(i).array());
  const auto is_off = [&](int i, double worth) {
    return std::abs(place[i]) > std::max(worth, kSigmas * out.sigmas[i]);
  };
  const bool is_moved = is_off(0, kWorthMoving) || is_off(1, kWorthMoving);
  out.T_robot_stated = SE2(is_moved ? place.x() : 0, is_moved ? place.y() : 0,
                           is_off(2, kWorthTurning) ? place.z() : 0);
}

}  // namespace

LaserScan corrected(LaserScan scan, const LaserMounting& mounting) {
  const double half = 0.5 * (double(scan.ranges.size()) - 1) * scan.angle_step;
  const double middle = scan.first_angle + half;
  const double sign = mounting.mirrored ? -1 : 1;
  scan.first_angle = sign * (middle - mounting.widening * half);
  scan.angle_step *= sign * mounting.widening;
  const SE2& T = mounting.T_robot_stated;
  scan.T_robot_sensor = Eigen::Translation3d(T.x(), T.y(), 0) *
                        Eigen::AngleAxisd(T.angle(), Eigen::Vector3d::UnitZ()) *
                        scan.T_robot_sensor;
  return scan;
}

LaserMounting measure_mounting(const std::vector<MovedScan>& scans) {
  LaserMounting out;
  if (scans.size() < 2 * kFewestPairs) {
    out.unknown = "field of view, sense of rotation and place: too few scans";
    return out;
  }
  const std::vector<FollowedScan> path = follow(scans, {});
  measure_widening(scans, path, out);
  measure_place(scans, out.widening == 1 ? path : follow(scans, out), out);
  return out;
}

}  // namespace hybrid
