// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// How time and memory grow with the number of poses, on generated worlds: a Manhattan grid, a city
// with landmarks, a sphere. Each task is a process of its own, whose peak memory counts; robust has
// 10 % of its closures false.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <numeric>
#include <sstream>
#include <string>
#include <vector>

#include "bench/scale_worlds.h"
#include "bench/stopwatch.h"
#include "libhybrid/io/write_file.h"
#include "libhybrid/io/write_graph.h"
#include "libhybrid/marginals/continuous.h"
#include "libhybrid/methods/robust_methods.h"
#include "libhybrid/pose_graph/false_closures.h"
#include "libhybrid/pose_graph/pose_feed.h"
#include "libhybrid/smoother/incremental.h"
#include "libhybrid/solvers/levenberg_marquardt.h"

namespace {

using namespace hybrid;
using namespace hybrid::bench;

constexpr double kFalseShare = 0.1;
constexpr double kRobustClosures = 0.2;  // closures per pose that are left for "robust"

/// What a task took.
struct Measured {
  Time time;
  double worst_ms = 0.0;  ///< 99 % quantile over the steps; online only
  std::string text;       ///< what came out
};

/// The limits that this project sets itself, on two cores; processor time is the wall time of one.
struct Limit {
  const char* task;
  int poses;
  const char* what;
  double value;
};
constexpr std::array kLimits{
    Limit{"batch", 1000000, "cpu s", 90}, Limit{"batch", 1000000, "MiB", 8192},
    Limit{"online", 100000, "p99 ms", 20}, Limit{"robust", 100000, "cpu s", 60},
    Limit{"marginals", 100000, "cpu s", 5}};

template <class... Arguments>
std::string format(const char* form, Arguments... arguments) {
  std::array<char, 300> text{};
  std::snprintf(text.data(), text.size(), form, arguments...);
  return text.data();
}

HybridGraph graph_of(const PoseGraph& graph, const Values& initial) {
  return HybridGraph(to_factors(graph, initial));
}

/// Squared whitened residuals per degree of freedom; 1 where noise explains them.
double relative_chi_square(const World& world, double cost) {
  double residuals = 0, unknowns = 0;
  for (const auto& e : world.graph.poses2) residuals += e.noise.dim();
  for (const auto& e : world.graph.poses3) residuals += e.noise.dim();
  for (const auto& e : world.graph.points2) residuals += e.noise.dim();
  for (const Key key : world.truth.keys()) unknowns += world.truth.type(key).dim;
  return 2 * cost / (residuals - unknowns);
}

/// By how many residuals a change brings more than unknowns.
double freedom_of(const Delta& delta) {
  double freedom = 0;
  for (const ContinuousFactorPtr& factor : delta.continuous) freedom += factor->rows();
  for (const Key key : delta.values.keys()) freedom -= delta.values.type(key).dim;
  return freedom;
}

Measured batch(const World& world) {
  const Stopwatch watch;
  const Values initial = initialize_from_tree(world.graph);
  const SolverResult result = levenberg_marquardt(graph_of(world.graph, initial), {initial, {}});
  const double chi_square = relative_chi_square(world, result.report.final_cost());
  return {watch.elapsed(), 0,
          format("%d iterations, %s, chi-square %.4f per degree of freedom",
                 result.report.iterations, to_string(result.report.status).c_str(), chi_square)};
}

Measured online(const World& world) {
  const Values initial = initialize_from_odometry(world.graph);
  PoseFeed feed(world.graph, initial);
  IncrementalSmoother smoother;
  std::vector<double> steps;
  double freedom = 0, off = 0;  // of the chi-square from 1, at every thousandth pose
  const Stopwatch watch;
  while (!feed.done()) {
    const Delta delta = feed.next(smoother.values());
    freedom += freedom_of(delta);
    const Stopwatch step;
    const UpdateReport report = smoother.update(delta);
    if (report.status != UpdateReport::Status::kOk) throw Error(report.message);
    steps.push_back(step.elapsed().cpu);
    if (steps.size() % 1000 == 0) off = std::max(off, std::abs(2 * smoother.cost() / freedom - 1));
  }
  const Time time = watch.elapsed();
  const Distribution d = distribution(steps);
  const auto last = static_cast<std::ptrdiff_t>(std::min<std::size_t>(steps.size(), 1000));
  const double at_end = std::accumulate(steps.end() - last, steps.end(), 0.0) / double(last);
  return {
      time, 1e3 * d.p99,
      format("step mean %.3f, of the last 1000 %.3f, p99 %.2f max %.1f ms, %.0f B per variable, "
             "chi-square %.4f, at every thousandth pose within %.3f of 1",
             1e3 * d.mean, 1e3 * at_end, 1e3 * d.p99, 1e3 * d.max,
             smoother.memory().bytes_per_variable, relative_chi_square(world, smoother.cost()),
             off)};
}

/// Leaves out closures, evenly, so that at most this many per pose remain.
template <class Pose>
void thin(std::vector<GraphEdge<Pose>>& edges, std::size_t most) {
  std::vector<GraphEdge<Pose>> kept;
  std::size_t closures = 0, seen = 0;
  for (const auto& e : edges) closures += !is_odometry(e.from, e.to);
  for (auto& e : edges) {
    if (!is_odometry(e.from, e.to)) {
      const std::size_t k = seen++;
      if (closures > most && k * most / closures == (k + 1) * most / closures) continue;
    }
    kept.push_back(std::move(e));
  }
  edges = std::move(kept);
}

/// A graph with few of its closures.
PoseGraph with_few_closures(World world) {
  const auto most = static_cast<std::size_t>(kRobustClosures * double(world.truth.size()));
  thin(world.graph.poses2, most);
  thin(world.graph.poses3, most);
  return std::move(world.graph);
}

std::size_t count_closures(const PoseGraph& graph) {
  std::size_t count = 0;
  for (const auto& e : graph.poses2) count += !is_odometry(e.from, e.to);
  for (const auto& e : graph.poses3) count += !is_odometry(e.from, e.to);
  return count;
}

Measured robust(World world, std::uint64_t seed) {
  const PoseGraph few = with_few_closures(std::move(world));
  const std::size_t right = count_closures(few);
  RobustTask task;
  task.graph = add_false_closures(few, kFalseShare, seed);
  const Values initial = initialize_from_odometry(task.graph);
  const Stopwatch watch;
  task.problem = to_robust_problem(task.graph, initial);
  const RobustResult result = robust_method("selection").solve(task, {});
  const Time time = watch.elapsed();
  std::size_t accepted = 0, good = 0;
  for (std::size_t k = 0; k < result.decisions.size(); ++k) {
    accepted += result.decisions[k].accepted();
    good += result.decisions[k].accepted() && k < right;
  }
  return {time, 0,
          format("%zu closures, %zu false, accepted %zu true and %zu false, %d iterations",
                 result.decisions.size(), result.decisions.size() - right, good, accepted - good,
                 result.iterations)};
}

Measured marginals(const World& world) {
  const HybridGraph graph = graph_of(world.graph, world.truth);
  const SolverResult optimum = levenberg_marquardt(graph, {world.truth, {}});
  const Stopwatch watch;
  const Covariances all = ContinuousMarginals(graph, {optimum.values, {}}).all();
  return {watch.elapsed(), 0, format("covariances of %zu variables", all.size())};
}

Measured run(const std::string& task, const World& world, std::uint64_t seed) {
  if (task == "batch") return batch(world);
  if (task == "online") return online(world);
  if (task == "robust") return robust(world, seed);
  if (task == "marginals") return marginals(world);
  throw Error("there is no task '" + task + "': batch, online, robust or marginals");
}

/// A row of the table.
struct Row {
  std::string world, task;
  int poses = 0;
  std::size_t edges = 0;
  Measured measured;
  double mib = 0.0;  ///< peak of the process, the world included
};

std::string read_all(int from) {
  std::string text;
  std::array<char, 4096> buffer{};
  for (ssize_t n = 0; (n = ::read(from, buffer.data(), buffer.size())) > 0;) {
    text.append(buffer.data(), static_cast<std::size_t>(n));
  }
  return text;
}

/// Runs a task in a process of its own.
Row measure(const std::string& world, const std::string& task, int poses, std::uint64_t seed) {
  std::array<int, 2> ends{};
  if (::pipe(ends.data()) != 0) throw Error("no pipe");
  const pid_t child = ::fork();
  if (child < 0) throw Error("no process");
  if (child == 0) {
    ::close(ends[0]);
    std::string text;
    try {
      const World made = scale_world(world, poses, seed);
      const Measured m = run(task, made, seed);
      text = format("%zu %.9g %.9g %.9g ", made.graph.edge_count(), m.time.cpu, m.time.wall,
                    m.worst_ms) +
             m.text;
    } catch (const std::exception& e) {
      text = format("0 nan nan 0 %s", e.what());
    }
    const bool written = ::write(ends[1], text.data(), text.size()) == ssize_t(text.size());
    ::_exit(written ? 0 : 1);
  }
  ::close(ends[1]);
  Row row{world, task, poses, 0, {}, 0};
  std::istringstream text(read_all(ends[0]));
  ::close(ends[0]);
  int status = 0;
  rusage usage{};
  ::wait4(child, &status, 0, &usage);
  row.mib = static_cast<double>(usage.ru_maxrss) / 1024;
  std::string cpu, wall;
  text >> row.edges >> cpu >> wall >> row.measured.worst_ms;
  row.measured.time = {std::atof(wall.c_str()), std::atof(cpu.c_str())};
  std::getline(text >> std::ws, row.measured.text);
  if (status != 0 || row.edges == 0) row.measured.time = {std::nan(""), std::nan("")};
  if (status != 0) row.measured.text = format("ended with status %d", status);
  return row;
}

void print(const Row& row) {
  std::printf("%-9s %-9s %8d poses %8zu edges %9.2f s cpu %9.2f s wall %8.0f MiB  %s\n",
              row.world.c_str(), row.task.c_str(), row.poses, row.edges, row.measured.time.cpu,
              row.measured.time.wall, row.mib, row.measured.text.c_str());
  for (const Limit& limit : kLimits) {
    if (row.task != limit.task || row.poses != limit.poses) continue;
    const std::string what = limit.what;
    const double value = what == "MiB"      ? row.mib
                         : what == "p99 ms" ? row.measured.worst_ms
                                            : row.measured.time.cpu;
    std::printf("    limit %g %s: %s\n", limit.value, limit.what,
                value <= limit.value ? "met" : "missed");
  }
  std::fflush(stdout);
}

/// Least-squares slope of log y over log x.
double slope(const std::vector<std::pair<double, double>>& points) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (const auto& [x, y] : points) {
    const double u = std::log(x), v = std::log(y);
    n += 1, sx += u, sy += v, sxx += u * u, sxy += u * v;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

void print_slopes(const std::vector<Row>& rows) {
  std::map<std::string, std::vector<std::pair<double, double>>> time, memory;
  for (const Row& row : rows) {
    if (!(row.measured.time.cpu > 0)) continue;
    time[row.world + " " + row.task].emplace_back(row.poses, row.measured.time.cpu);
    memory[row.world + " " + row.task].emplace_back(row.poses, row.mib);
  }
  for (const auto& [name, points] : time) {
    if (points.size() < 2) continue;
    std::printf("%-20s time grows as n^%.2f, memory as n^%.2f\n", name.c_str(), slope(points),
                slope(memory[name]));
  }
}

struct Settings {
  std::vector<int> poses = {1000, 3000, 10000, 30000, 100000};
  std::vector<std::string> worlds = {"manhattan", "city", "sphere"};
  std::vector<std::string> tasks = {"batch", "online", "robust", "marginals"};
  std::uint64_t seed = 1;
  std::string csv, g2o;
};

/// Writes the graphs as NAME_POSES.g2o, and those of the robust task as NAME_POSES_robust.g2o.
void write_graphs(const Settings& settings) {
  const auto write = [&](PoseGraph graph, const std::string& name) {
    graph.values = initialize_from_odometry(graph);
    write_g2o(settings.g2o + "/" + name + ".g2o", graph);
  };
  const auto robust =
      std::count(settings.tasks.begin(), settings.tasks.end(), std::string("robust"));
  std::filesystem::create_directories(settings.g2o);
  for (const std::string& world : settings.worlds) {
    for (const int poses : settings.poses) {
      World made = scale_world(world, poses, settings.seed);
      const std::string name = world + "_" + std::to_string(poses);
      write(made.graph, name);
      if (robust == 0) continue;
      const PoseGraph few = with_few_closures(std::move(made));
      write(add_false_closures(few, kFalseShare, settings.seed), name + "_robust");
    }
  }
}

void run_all(const Settings& settings) {
  std::vector<Row> rows;
  for (const std::string& world : settings.worlds) {
    for (const std::string& task : settings.tasks) {
      for (const int poses : settings.poses) {
        rows.push_back(measure(world, task, poses, settings.seed));
        print(rows.back());
      }
    }
  }
  print_slopes(rows);
  if (!settings.g2o.empty()) write_graphs(settings);
  if (settings.csv.empty()) return;
  std::string csv = "case,poses,cpu_s,peak_mib\n";
  for (const Row& row : rows) {
    if (!(row.measured.time.cpu > 0)) continue;
    csv += format("%s %s,%d,%.6f,%.1f\n", row.world.c_str(), row.task.c_str(), row.poses,
                  row.measured.time.cpu, row.mib);
  }
  write_file(settings.csv, csv);
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app("Time and memory of batch, online, robust and marginals as generated worlds grow");
  Settings settings;
  app.add_option("--poses", settings.poses, "Sizes of the worlds, at least 100 poses")
      ->delimiter(',')
      ->check(CLI::Range(100, 100000000))
      ->capture_default_str();
  app.add_option("--worlds", settings.worlds, "Some of manhattan, city and sphere")
      ->delimiter(',')
      ->check(CLI::IsMember({"manhattan", "city", "sphere"}))
      ->capture_default_str();
  app.add_option("--tasks", settings.tasks, "Some of batch, online, robust and marginals")
      ->delimiter(',')
      ->check(CLI::IsMember({"batch", "online", "robust", "marginals"}))
      ->capture_default_str();
  app.add_option("--seed", settings.seed, "Of the worlds")->capture_default_str();
  app.add_option("--csv", settings.csv, "Write the figures here, too; plot-growth draws them");
  app.add_option("--g2o", settings.g2o,
                 "Write the graphs into this folder, too, for other programs");
  CLI11_PARSE(app, argc, argv);
  run_all(settings);
  return EXIT_SUCCESS;
} catch (const std::exception& e) {
  std::fprintf(stderr, "bench-scale: %s\n", e.what());
  return EXIT_FAILURE;
}
