// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// The incremental smoother beside iSAM2 of GTSAM, on the same graphs, fed alike: pose by pose, with
// a full estimate after each. iSAM2 takes Gauss-Newton steps, and linearises again at every step
// what has moved by more than its threshold of 0.1.
#include <gtsam/geometry/BearingRange.h>
#include <gtsam/geometry/Pose2.h>
#include <gtsam/geometry/Pose3.h>
#include <gtsam/inference/Symbol.h>
#include <gtsam/nonlinear/ISAM2.h>
#include <gtsam/nonlinear/PriorFactor.h>
#include <gtsam/sam/BearingRangeFactor.h>
#include <gtsam/slam/BetweenFactor.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "bench/graph_feed.h"
#include "bench/growth_rows.h"
#include "bench/stopwatch.h"
#include "libhybrid/core/error.h"
#include "libhybrid/io/write_file.h"
#include "libhybrid/smoother/incremental.h"
#include "tests/support/data_path.h"

namespace {

using namespace hybrid;
using namespace hybrid::bench;

/// What a smoother took for a graph.
struct Run {
  std::vector<double> steps;  ///< processor time of each [s]
  double cost = 0.0;          ///< half the weighted squared error after the last
};

gtsam::Key key_of(Key key) {
  return gtsam::Symbol(static_cast<unsigned char>(key.letter()), key.index());
}

gtsam::Pose2 to_gtsam(const SE2& pose) {
  return {pose.x(), pose.y(), pose.angle()};
}
gtsam::Pose3 to_gtsam(const SE3& pose) {
  return {gtsam::Rot3(pose.rotation().matrix()), pose.translation()};
}

/// Information in the order in which GTSAM has the tangents: rotations before translations in
/// space, bearings before ranges.
gtsam::SharedNoiseModel noise_of(const Noise& noise, bool turns_first) {
  const Eigen::MatrixXd information = noise.information();
  if (!turns_first) return gtsam::noiseModel::Gaussian::Information(information);
  const Eigen::Index half = noise.dim() / 2;
  Eigen::MatrixXd turned(noise.dim(), noise.dim());
  turned << information.bottomRightCorner(half, half), information.bottomLeftCorner(half, half),
      information.topRightCorner(half, half), information.topLeftCorner(half, half);
  return gtsam::noiseModel::Gaussian::Information(turned);
}

/// iSAM2 fed by the steps of a graph.
class Isam2 {
 public:
  Isam2() : smoother_(parameters()) {}

  void update(const Step& step) {
    if (estimate_.empty()) start(step.front());
    for (const Measurement& m : step) std::visit([&](const auto& z) { add(m, z); }, m.measured);
    smoother_.update(factors_, values_);
    factors_.resize(0);
    values_.clear();
    estimate_ = smoother_.calculateEstimate();
  }

  double cost() const { return smoother_.getFactorsUnsafe().error(estimate_); }

 private:
  static gtsam::ISAM2Params parameters() {
    gtsam::ISAM2Params out;
    out.relinearizeThreshold = 0.1;
    out.relinearizeSkip = 1;
    return out;
  }

  void start(const Measurement& m) {
    const bool point = std::holds_alternative<Eigen::Vector2d>(m.measured);
    const Key first = point ? m.from : std::min(m.from, m.to);
    std::holds_alternative<SE3>(m.measured) ? add_prior<gtsam::Pose3>(first)
                                            : add_prior<gtsam::Pose2>(first);
  }

  template <class Pose>
  void add_prior(Key key) {
    values_.insert(key_of(key), Pose());
    factors_.emplace_shared<gtsam::PriorFactor<Pose>>(
        key_of(key), Pose(), gtsam::noiseModel::Isotropic::Sigma(Pose::dimension, 0.01));
  }

  template <class Pose>
  void add(const Measurement& m, const Pose& measured) {
    const auto z = to_gtsam(measured);
    using Theirs = std::decay_t<decltype(z)>;
    const gtsam::Key from = key_of(m.from), to = key_of(m.to);
    if (!has(to)) values_.insert(to, at<Theirs>(from) * z);
    if (!has(from)) values_.insert(from, at<Theirs>(to) * z.inverse());
    factors_.emplace_shared<gtsam::BetweenFactor<Theirs>>(
        from, to, z, noise_of(m.noise, Theirs::dimension == 6));
  }

  void add(const Measurement& m, const Eigen::Vector2d& z) {
    const gtsam::Key from = key_of(m.from), to = key_of(m.to);
    const gtsam::Rot2 bearing(z.y());
    if (!has(to)) {
      const gtsam::Point2 seen = bearing * gtsam::Point2(z.x(), 0);
      values_.insert(to, gtsam::Point2(at<gtsam::Pose2>(from).transformFrom(seen)));
    }
    factors_.emplace_shared<gtsam::BearingRangeFactor<gtsam::Pose2, gtsam::Point2>>(
        from, to, bearing, z.x(), noise_of(m.noise, true));
  }

  bool has(gtsam::Key key) const { return values_.exists(key) || estimate_.exists(key); }

  template <class T>
  T at(gtsam::Key key) const {
    return values_.exists(key) ? values_.at<T>(key) : estimate_.at<T>(key);
  }

  gtsam::ISAM2 smoother_;
  gtsam::NonlinearFactorGraph factors_;
  gtsam::Values values_, estimate_;
};

Run run_ours(const std::vector<Step>& steps) {
  Run run;
  IncrementalSmoother smoother;
  for (const Step& step : steps) {
    const Stopwatch watch;
    const UpdateReport report = smoother.update(to_delta(step, smoother.values()));
    if (report.status != UpdateReport::Status::kOk) throw Error(report.message);
    run.steps.push_back(watch.elapsed().cpu);
  }
  run.cost = smoother.cost();
  return run;
}

Run run_isam2(const std::vector<Step>& steps) {
  Run run;
  Isam2 smoother;
  for (const Step& step : steps) {
    const Stopwatch watch;
    smoother.update(step);
    run.steps.push_back(watch.elapsed().cpu);
  }
  run.cost = smoother.cost();
  return run;
}

/// Runs both and prints a line; returns rows of step time over graph size.
std::string compare(const std::string& path) {
  const std::string name = std::filesystem::path(path).stem().string();
  const std::vector<Step> steps = read_steps(path);
  const Run ours = run_ours(steps), theirs = run_isam2(steps);
  const Distribution a = distribution(ours.steps), b = distribution(theirs.steps);
  std::printf("%-28s %7zu %9.3f %9.3f %6.1f %8.2f %8.2f %8.1f %8.1f  %.6g %.6g\n", name.c_str(),
              steps.size(), a.total, b.total, b.total / a.total, 1e3 * a.p99, 1e3 * b.p99,
              1e3 * a.max, 1e3 * b.max, ours.cost, theirs.cost);
  std::fflush(stdout);
  return growth_rows(name, ours.steps) + growth_rows(name + " iSAM2", theirs.steps);
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app(
      "The incremental smoother beside iSAM2 of GTSAM on the same graphs, fed pose by pose with a "
      "full estimate after each: processor time and final cost");
  std::vector<std::string> graphs;
  std::string csv;
  app.add_option("GRAPH", graphs, "g2o or TORO files; the public ones by default");
  app.add_option("--csv", csv, "Write the time per step against the size; plot-growth draws it");
  CLI11_PARSE(app, argc, argv);
  if (graphs.empty()) {
    for (const char* path :
         {"pose_graphs/CSAIL.g2o", "pose_graphs/intel.g2o", "pose_graphs/manhattan.g2o",
          "pose_graphs_gt/manhattanOlson3500.g2o", "pose_graphs/parking-garage.g2o",
          "pose_graphs/sphere2500.g2o", "pose_graphs/city10000.g2o",
          "victoria_park/victoria_park_known_assoc_gtsam.txt"}) {
      graphs.push_back(hybrid::testing::data_path(path));
    }
  }
  std::printf("%-28s %7s %9s %9s %6s %8s %8s %8s %8s  %s\n", "graph", "steps", "ours [s]",
              "iSAM2 [s]", "ratio", "p99 [ms]", "iSAM2", "max [ms]", "iSAM2", "cost, iSAM2");
  std::string rows = kGrowthHeader;
  for (const std::string& path : graphs) rows += compare(path);
  if (!csv.empty()) write_file(csv, rows);
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "bench-isam2: %s\n", e.what());
  return 1;
}
