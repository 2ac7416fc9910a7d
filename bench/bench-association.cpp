// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Time per keyframe of mapping with unknown association, while the map grows at constant density.
//
//   bench-association [--sightings N] [--csv F] [--png F]
//
// A robot drives twice around each block of a row. A block has ten landmarks without ids, and there
// are spurious detections. Times are processor times.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <random>
#include <string>
#include <vector>

#include "libhybrid/io/write_file.h"
#include "mrpt_plugins/drawing/plot.h"
#include "mrpt_plugins/evaluation/landmark_metrics.h"
#include "mrpt_plugins/mapping/mapper.h"

namespace hybrid {
namespace {

using mrpt::poses::CPose3D;

constexpr int kPerBlock = 10, kStepsPerRound = 24, kWay = 20;  // steps to the next block
constexpr double kRadius = 10, kReach = 9, kSpacing = 30;      // m
constexpr double kSigmaMotion = 0.03, kSigmaTurn = 0.005, kSigmaRange = 0.1, kSigmaYaw = 0.01;

struct World {
  std::mt19937 random{7};
  std::vector<Eigen::Vector2d> landmarks;
  CPose3D last;

  double gauss(double sigma) { return sigma * std::normal_distribution<double>()(random); }
  double uniform(double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  }

  /// The pose at step i: twice around a block, then straight to the next one.
  static CPose3D pose(int i) {
    constexpr int kRounds = 2 * kStepsPerRound;
    const int block = i / (kRounds + kWay), k = i % (kRounds + kWay);
    const double x = kSpacing * block, turn = 2 * M_PI / kStepsPerRound;
    if (k < kRounds) {
      return {
          x + kRadius * std::sin(turn * k), kRadius * (1 - std::cos(turn * k)), 0, turn * k, 0, 0};
    }
    return {x + kSpacing * (k - kRounds) / kWay, 0, 0, 0, 0, 0};
  }

  Keyframe keyframe(int i) {
    const CPose3D now = pose(i);
    while (landmarks.size() < kPerBlock * static_cast<std::size_t>(now.x() / kSpacing + 2)) {
      const std::size_t block = landmarks.size() / kPerBlock;
      const double x = kSpacing * static_cast<double>(block);
      const double a = uniform(-M_PI, M_PI), r = kRadius + uniform(-5, 5);
      landmarks.emplace_back(x + r * std::cos(a), kRadius + r * std::sin(a));
    }
    Keyframe out;
    out.row = static_cast<std::size_t>(i);
    out.time = i;
    if (i > 0) {
      OdometryIncrement odometry;
      odometry.mean = (now - last) +
                      CPose3D(gauss(kSigmaMotion), gauss(kSigmaMotion), 0, gauss(kSigmaTurn), 0, 0);
      odometry.is_planar = true;
      odometry.covariance.diagonal() << kSigmaMotion * kSigmaMotion, kSigmaMotion * kSigmaMotion,
          1e-4, 1e-4, 1e-4, kSigmaTurn * kSigmaTurn;
      out.odometry = odometry;
    }
    last = now;
    DetectionFrame frame;
    frame.is_3d = false;
    frame.max_range = kReach;
    frame.fov_yaw = 2 * M_PI;
    const std::size_t near = kPerBlock * static_cast<std::size_t>(std::lround(now.x() / kSpacing));
    for (std::size_t id = near < kPerBlock ? 0 : near - kPerBlock;
         id < std::min(landmarks.size(), near + 2 * kPerBlock); ++id) {
      Detection d;
      now.sphericalCoordinates({landmarks[id].x(), landmarks[id].y(), 0}, d.range, d.yaw, d.pitch);
      if (d.range > kReach || uniform(0, 1) > 0.9) continue;
      d.true_id = static_cast<std::int64_t>(id);
      add(d, frame);
    }
    if (uniform(0, 1) < 0.3) {
      Detection d;
      d.range = uniform(1, kReach);
      d.yaw = uniform(-M_PI, M_PI);
      add(d, frame);
    }
    out.detections = {frame};
    return out;
  }

  void add(Detection d, DetectionFrame& frame) {
    d.range = std::max(0.01, d.range + gauss(kSigmaRange));
    d.yaw = std::remainder(d.yaw + gauss(kSigmaYaw), 2 * M_PI);
    d.pitch = 0;
    d.covariance.diagonal() << kSigmaRange * kSigmaRange, kSigmaYaw * kSigmaYaw, 0;
    frame.detections.push_back(d);
  }
};

struct Bin {
  std::size_t sightings = 0, landmarks = 0;
  std::vector<double> ms;
  double plugin_ms = 0;  // share of association in it

  double mean() const {
    double sum = 0;
    for (double t : ms) sum += t;
    return sum / static_cast<double>(ms.size());
  }
  double association() const { return plugin_ms / static_cast<double>(ms.size()); }
  double p95() const {
    std::vector<double> sorted = ms;
    std::sort(sorted.begin(), sorted.end());
    return sorted[sorted.size() * 95 / 100];
  }
};

std::vector<Bin> grow(std::size_t sightings, Mapper& mapper, World& world) {
  constexpr std::size_t kKeyframesPerBin = 10 * (2 * kStepsPerRound + kWay);  // ten blocks
  std::vector<Bin> bins(1);
  std::size_t seen = 0;
  for (int i = 0; seen < sightings; ++i) {
    const Keyframe keyframe = world.keyframe(i);
    seen += keyframe.detections.front().detections.size();
    const std::clock_t start = std::clock();
    bins.back().plugin_ms += mapper.add(keyframe)->plugin_ms;
    bins.back().ms.push_back(1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
    bins.back().sightings = seen;
    bins.back().landmarks = mapper.landmarks().size();
    if (bins.back().ms.size() < kKeyframesPerBin) continue;
    std::fprintf(stderr, "%zu sightings, %.2f ms a keyframe\n", seen, bins.back().mean());
    bins.emplace_back();
  }
  if (bins.back().ms.empty()) bins.pop_back();
  return bins;
}

void draw(const std::vector<Bin>& bins, const std::string& file) {
  Series mean{"mean", {}, {}}, p95{"95 %", {}, {}};
  p95.color = palette::kTruth;
  for (const Bin& bin : bins) {
    mean.x.push_back(static_cast<double>(bin.sightings));
    mean.y.push_back(bin.mean());
    p95.x.push_back(static_cast<double>(bin.sightings));
    p95.y.push_back(bin.p95());
  }
  PlotSpec spec;
  spec.title = "Mapping with unknown association: time per keyframe";
  spec.subtitle = fmt::format(
      "{} landmarks at the end, tentative ones included; {} keyframes per point; processor time",
      bins.back().landmarks, bins.front().ms.size());
  spec.x.label = "sightings so far";
  spec.y.label = "time per keyframe (ms)";
  spec.series = {mean, p95};
  write_file(file, png(render(spec)));
}

int run(std::size_t sightings, const std::string& csv, const std::string& picture) {
  IniFile ini("", "defaults");
  Mapper mapper(read_motion_options(ini), {make_plugin("BearingRangeAssociation", ini)},
                make_backend(ini.section("solver")), false);
  World world;
  const std::vector<Bin> bins = grow(sightings, mapper, world);
  const std::vector<AssociationDecision> decisions = mapper.decisions();
  auto first = decisions.begin();
  std::string text = "sightings,landmarks,mean_ms,p95_ms,association_wall_ms,right\n";
  for (const Bin& bin : bins) {
    const auto last = decisions.begin() + static_cast<std::ptrdiff_t>(bin.sightings);
    text +=
        fmt::format("{},{},{:.4f},{:.4f},{:.4f},{:.4f}\n", bin.sightings, bin.landmarks, bin.mean(),
                    bin.p95(), bin.association(), association_report({first, last}).accuracy());
    first = last;
  }
  if (!csv.empty()) write_file(csv, text);
  if (!picture.empty()) draw(bins, picture);
  const AssociationReport report = association_report(decisions);
  fmt::print("{}associations right: {:.2f} %\n", text, 100 * report.accuracy());
  return 0;
}

}  // namespace
}  // namespace hybrid

int main(int argc, char** argv) {
  CLI::App app("Time per keyframe of mapping with unknown association while the map grows.");
  std::size_t sightings = 100000;
  std::string csv, picture;
  app.add_option("--sightings", sightings, "Stop after so many");
  app.add_option("--csv", csv, "Time against the size of the map");
  app.add_option("--png", picture, "The same as a picture");
  CLI11_PARSE(app, argc, argv);
  return hybrid::run(sightings, csv, picture);
}
