// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/mapper.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include "mrpt_plugins/mapping/space.h"

namespace hybrid {
namespace {

template <class T>
void append(std::vector<T>& to, const std::vector<T>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

void merge(Delta& into, const Delta& from) {
  append(into.continuous, from.continuous);
  append(into.discrete, from.discrete);
  append(into.hybrid, from.hybrid);
  append(into.remove, from.remove);
  append(into.remove_values, from.remove_values);
  for (const Key key : from.values.keys()) {
    into.values.insert(key, from.values.type(key), from.values.data(key));
  }
  for (const auto& [key, value] : from.assignment) into.assignment.set(key, value);
}

/// Counts the work of one more update; the estimate is that of the later one.
void add_work(BackendReport& into, const BackendReport& from) {
  into.seconds += from.seconds;
  into.iterations += from.iterations;
  into.flips += from.flips;
  into.relinearized += from.relinearized;
  into.exact = into.exact && from.exact;
  into.objective = from.objective;
  if (from.cost != 0 || into.cost == 0) into.cost = from.cost;
  append(into.half_steps, from.half_steps);
  append(into.warnings, from.warnings);
}

/// Joint covariance of a pose that `motion` ties to the one before, or to the origin, and of some
/// variables of the map. With r = A da + B db for the linear motion, db = B^-1 (r - A da).
Eigen::MatrixXd covariance_after_motion(const ContinuousFactor& motion, const Values& newest,
                                        const Backend& backend, std::vector<Key> keys) {
  const bool first = motion.keys().size() == 1;
  std::vector<const double*> x;
  for (const Key key : motion.keys()) {
    x.push_back(newest.contains(key) ? newest.data(key) : backend.values().data(key));
  }
  const int rows = motion.rows();
  Eigen::VectorXd r(rows);
  Eigen::MatrixXd J(rows, motion.cols());
  motion.linearize(x.data(), r.data(), J.data());
  const Eigen::MatrixXd noise = J.rightCols(rows).inverse();
  if (first) return noise * noise.transpose();
  keys.insert(keys.begin(), motion.keys().front());
  Eigen::MatrixXd joint = backend.joint_covariance(keys);
  const Eigen::MatrixXd F = -noise * J.leftCols(rows);
  joint.topRows(rows) = (F * joint.topRows(rows)).eval();
  joint.leftCols(rows) = (joint.leftCols(rows) * F.transpose()).eval();
  joint.topLeftCorner(rows, rows) += noise * noise.transpose();
  return joint;
}

/// What a call returns; its wall time is added to `ms`.
template <class Call>
auto timed(double& ms, Call&& call) {
  const auto start = std::chrono::steady_clock::now();
  auto result = call();
  ms += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return result;
}

/// A covariance of a point of 2 or 3 as 3x3.
Eigen::Matrix3d padded(const Eigen::MatrixXd& covariance) {
  Eigen::Matrix3d out = Eigen::Matrix3d::Zero();
  out.topLeftCorner(covariance.rows(), covariance.cols()) = covariance;
  return out;
}

}  // namespace

Mapper::Mapper(const MotionOptions& options, std::vector<std::shared_ptr<MappingPlugin>> plugins,
               std::unique_ptr<Backend> backend, bool is_3d, const CalibrationOptions& calibration)
    : options_(options),
      plugins_(std::move(plugins)),
      backend_(std::move(backend)),
      is_3d_(is_3d),
      calibrator_(calibration, is_3d) {
  check(options_, is_3d_);
}

const StepRecord& Mapper::add(const Keyframe& raw) try {
  Keyframe keyframe = raw;
  plugin_ms_ = 0;
  Delta delta = move(keyframe);
  calibrator_.place_sensors(keyframe.detections, backend_->values(), delta);
  std::vector<Contribution> contributions;
  for (const auto& plugin : plugins_) contributions.push_back(observe(*plugin, keyframe, delta));
  BackendReport report = take_in(std::move(delta), contributions);
  add_work(report, revise(false));
  T_map_robot_ = pose_at(backend_->values(), pose_key(steps_.size()));
  steps_.push_back(record(keyframe, report));
  log_rows_.push_back(keyframe.row);
  return steps_.back();
} catch (const Error& e) {
  throw Error(fmt::format("frame {} of the log: {}", raw.row, e.what()));
}

Delta Mapper::move(const Keyframe& keyframe) {
  Delta delta;
  const std::size_t i = steps_.size();
  if (i == 0) {
    predicted_by_ = origin_factor(pose_key(0), options_, is_3d_);
    delta.continuous.push_back(predicted_by_);
    dead_reckoning_.push_back({keyframe.time, T_map_robot_});
  } else {
    if (!keyframe.odometry) ++dropped_["odometry missing: robot taken to stand still"];
    const OdometryIncrement motion =
        keyframe.odometry ? *keyframe.odometry : unknown_motion(options_, is_3d_);
    predicted_by_ = odometry_factor(pose_key(i - 1), pose_key(i), motion, options_, is_3d_);
    add_motion(i, motion, keyframe.odometry.has_value(), delta);
    T_map_robot_ = T_map_robot_ + calibrator_.corrected(motion.mean, backend_->values());
    dead_reckoning_.push_back({keyframe.time, dead_reckoning_.back().pose + motion.mean});
  }
  insert_pose(delta.values, pose_key(i), T_map_robot_, is_3d_);
  return delta;
}

/// The factors of the motion to pose i. Where odometry is missing it has no mode and no
/// calibration.
void Mapper::add_motion(std::size_t i, const OdometryIncrement& motion, bool measured,
                        Delta& delta) {
  const Key from = pose_key(i - 1), to = pose_key(i);
  const std::optional<Key> calibration = measured ? calibrator_.odometry(delta) : std::nullopt;
  if (options_.modes.empty() || !measured) {
    delta.continuous.push_back(odometry_factor(from, to, motion, options_, is_3d_, calibration));
    last_mode_.reset();
  } else {
    const DiscreteKey mode{Key('m', i), static_cast<int>(options_.modes.size())};
    delta.hybrid.push_back(switching_factor(mode, from, to, motion, options_, is_3d_, calibration));
    delta.discrete.push_back(last_mode_ ? chain_step(options_.chain, *last_mode_, mode)
                                        : chain_tables(options_.chain, {mode}).front());
    last_mode_ = mode;
  }
  if (options_.steady_sigma_m > 0 && i >= 2) {
    delta.continuous.push_back(steady_factor(pose_key(i - 2), from, to, options_, is_3d_));
  }
}

MapView Mapper::view() const {
  MapView view{backend_->values(), backend_->assignment(), landmarks_, is_3d_};
  view.keeps_all = backend_->keeps_all();
  view.holds = [this](Key key) { return backend_->holds(key); };
  view.joint_covariance = [this](const std::vector<Key>& keys) {
    return backend_->joint_covariance(keys);
  };
  return view;
}

Contribution Mapper::observe(MappingPlugin& plugin, const Keyframe& keyframe, const Delta& motion) {
  const Frame frame{pose_key(steps_.size()), T_map_robot_, keyframe.detections,
                    keyframe.observations};
  MapView map = view();
  map.joint_covariance = [&](const std::vector<Key>& keys) {
    return covariance_after_motion(*predicted_by_, motion.values, *backend_, keys);
  };
  Contribution contribution = timed(plugin_ms_, [&] { return plugin.observe(frame, map); });
  enter(contribution);
  return contribution;
}

void Mapper::enter(const Contribution& contribution) {
  for (const Landmark& landmark : contribution.landmarks) landmarks_.add(landmark);
  for (const std::int64_t id : contribution.sighted) landmarks_.sighted(id);
  for (const std::int64_t id : contribution.unsighted) landmarks_.unsighted(id);
  for (const std::int64_t id : contribution.forgotten) landmarks_.remove(id);
  for (const auto& [reason, count] : contribution.dropped) dropped_[reason] += count;
}

/// One update with what the motion (in `delta`) and the plugins say; tells each plugin its part.
BackendReport Mapper::take_in(Delta&& delta, const std::vector<Contribution>& contributions) {
  std::array<std::size_t, 3> next = {delta.continuous.size(), delta.discrete.size(),
                                     delta.hybrid.size()};
  for (const Contribution& contribution : contributions) merge(delta, contribution.delta);
  next[1] += delta.continuous.size();
  next[2] += delta.continuous.size() + delta.discrete.size();
  BackendReport report = backend_->update(delta);
  const bool settle = std::any_of(contributions.begin(), contributions.end(),
                                  [](const Contribution& c) { return c.settle; });
  if (settle) add_work(report, backend_->finish());
  for (std::size_t p = 0; p < contributions.size(); ++p) {
    const Delta& own = contributions[p].delta;
    Outcome outcome{{}, objective_, report.objective, report.exact};
    const std::array<std::size_t, 3> count = {own.continuous.size(), own.discrete.size(),
                                              own.hybrid.size()};
    for (std::size_t kind = 0; kind < 3; ++kind) {
      for (std::size_t i = 0; i < count[kind]; ++i) {
        outcome.handles.push_back(report.handles.at(next[kind]++));
      }
    }
    plugins_[p]->applied(outcome);
  }
  ++updates_;
  if (!report.exact) ++updates_by_local_search_;
  objective_ = report.objective;
  return report;
}

/// Lets the plugins change their minds until they are content.
BackendReport Mapper::revise(bool concluding) {
  BackendReport work;
  work.objective = objective_;
  for (bool again = true; again;) {
    std::vector<Contribution> contributions;
    for (const auto& plugin : plugins_) {
      contributions.push_back(timed(plugin_ms_, [&] {
        return concluding ? plugin->conclude(view()) : plugin->revise(view());
      }));
      enter(contributions.back());
    }
    again = std::any_of(contributions.begin(), contributions.end(),
                        [](const Contribution& c) { return !c.empty(); });
    if (again) add_work(work, take_in({}, contributions));
  }
  return work;
}

StepRecord Mapper::record(const Keyframe& keyframe, const BackendReport& report) const {
  StepRecord step;
  step.keyframe = static_cast<int>(steps_.size());
  step.time = keyframe.time;
  step.solver_ms = 1e3 * report.seconds;
  step.plugin_ms = plugin_ms_;
  step.iterations = report.iterations;
  step.flips = report.flips;
  step.relinearized = report.relinearized;
  step.objective = report.objective;
  step.cost = report.cost;
  step.landmarks = landmarks_.size();
  return step;
}

BackendReport Mapper::finish() {
  BackendReport work = revise(true);
  add_work(work, backend_->finish());
  return work;
}

std::vector<AssociationDecision> Mapper::decisions() const {
  std::vector<AssociationDecision> all;
  for (const auto& plugin : plugins_) append(all, plugin->decisions(view()));
  return all;
}

std::map<std::string, double> Mapper::statistics() const {
  std::map<std::string, double> all = {
      {"updates", static_cast<double>(updates_)},
      {"updates_by_local_search", static_cast<double>(updates_by_local_search_)}};
  for (const auto& plugin : plugins_) all.merge(plugin->statistics());
  return all;
}

std::vector<std::string> Mapper::class_names() const {
  for (const auto& plugin : plugins_) {
    if (!plugin->class_names().empty()) return plugin->class_names();
  }
  return {};
}

MapResult Mapper::result() const {
  MapResult result;
  result.is_3d = is_3d_;
  result.class_names = class_names();
  result.dead_reckoning = dead_reckoning_;
  result.steps = steps_;
  add_modes(result);
  result.calibration = calibrator_.estimates(*backend_);
  const Values& values = backend_->values();
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    result.trajectory.push_back({steps_[i].time, pose_at(values, pose_key(i))});
  }
  std::vector<Key> points;
  std::vector<DiscreteKey> classes;
  for (const auto& [id, landmark] : landmarks_) {
    points.push_back(landmark.position);
    if (landmark.class_key) classes.push_back(*landmark.class_key);
  }
  const Uncertainty uncertainty = backend_->uncertainty(points, classes);
  for (const auto& [id, landmark] : landmarks_) {
    LandmarkEstimate out;
    out.id = id;
    out.position = point_at(values, landmark.position);
    out.is_3d = is_3d_;
    out.sightings = landmark.sightings;
    const auto covariance = uncertainty.covariances.find(landmark.position);
    if (covariance != uncertainty.covariances.end()) out.covariance = padded(covariance->second);
    if (landmark.class_key) {
      out.class_index = backend_->assignment().at(landmark.class_key->key);
      const auto p = uncertainty.probabilities.find(landmark.class_key->key);
      if (p != uncertainty.probabilities.end()) out.class_probabilities = p->second;
    }
    result.landmarks.push_back(std::move(out));
  }
  return result;
}

void Mapper::add_modes(MapResult& result) const {
  if (options_.modes.empty()) return;
  std::vector<DiscreteKey> keys;
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    const DiscreteKey key{Key('m', i), static_cast<int>(options_.modes.size())};
    const int mode = backend_->assignment().find(key.key);
    result.motion_modes.push_back(mode);
    if (mode >= 0) keys.push_back(key);
  }
  for (const MotionMode& mode : options_.modes) result.mode_names.push_back(mode.name);
  Uncertainty uncertainty = backend_->uncertainty({}, keys);
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    result.mode_probabilities.push_back(std::move(uncertainty.probabilities[Key('m', i)]));
  }
}

std::vector<Eigen::MatrixXd> Mapper::pose_covariances() const {
  std::vector<Key> keys;
  for (std::size_t i = 0; i < steps_.size(); ++i) keys.push_back(pose_key(i));
  Uncertainty uncertainty = backend_->uncertainty(keys, {});
  std::vector<Eigen::MatrixXd> out(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const auto it = uncertainty.covariances.find(keys[i]);
    if (it != uncertainty.covariances.end()) out[i] = std::move(it->second);
  }
  return out;
}

}  // namespace hybrid
