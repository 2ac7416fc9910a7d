// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/initialization/placed_landmarks.h"

#include <algorithm>

#include "libhybrid/detections/sighting.h"

namespace hybrid {
namespace {

constexpr double kMore = 1.1;  // times the measurements before other places are tried again
constexpr int kDirections2 = 24, kDirections3 = 96;

}  // namespace

void PlacedLandmarks::place(PlacedLandmark landmark, const Priors& priors) {
  change_.placed.emplace_back(std::move(landmark), priors);
}

void PlacedLandmarks::measure(std::int64_t id, const Measurement& measurement, Key choice,
                              std::size_t factor) {
  change_.measured.push_back({id, {measurement, choice, {}}, factor});
}

void PlacedLandmarks::applied(const AddedHandles& handles) {
  for (const auto& [landmark, priors] : change_.placed) {
    std::vector<Handle>& own = placed_[landmark.id].priors;
    if (priors.of_class) own.push_back(handles.discrete[*priors.of_class]);
    if (priors.of_position) own.push_back(handles.continuous[*priors.of_position]);
  }
  for (Change::Measured& measured : change_.measured) {
    measured.taken.factor = handles.hybrid[measured.factor];
    placed_[measured.id].measurements.push_back(std::move(measured.taken));
    touched_.insert(measured.id);
  }
  change_ = {};
}

void PlacedLandmarks::refused() {
  for (auto& [landmark, priors] : change_.placed) {
    restarts_[landmark.id] = std::move(landmark.measurements);
  }
  for (auto& [id, landmark] : change_.taken_out) {
    restarts_.erase(id);
    placed_[id] = std::move(landmark);
  }
  change_ = {};
}

/// Whether more than half of the latest measurements, as many as an initialiser holds, are false.
bool PlacedLandmarks::is_doubtful(const Placed& landmark, const Assignment& assignment,
                                  const BankOptions& options) {
  const std::vector<Taken>& all = landmark.measurements;
  const auto count = std::min(all.size(), static_cast<std::size_t>(options.max_measurements));
  if (count < static_cast<std::size_t>(options.min_measurements)) return false;
  const auto wrong =
      std::count_if(all.end() - static_cast<std::ptrdiff_t>(count), all.end(), [&](const Taken& t) {
        return assignment.contains(t.choice) && assignment.at(t.choice) != 0;
      });
  return 2 * static_cast<std::size_t>(wrong) > count;
}

/// Whether other places surely explain the latest measurements better than `point`, even if it is
/// open which: a thing far ahead has no place any more once the robot has passed the wrong one.
/// Places in all directions from the newest pose, at half, once and twice the distance, are tried.
bool PlacedLandmarks::is_elsewhere(const Eigen::VectorXd& point, const Placed& landmark,
                                   const MapView& map, const BankOptions& options) {
  const auto pose = [&](Key key) { return map.values.data(key); };
  const std::vector<Taken>& all = landmark.measurements;
  const Eigen::VectorXd newest = Eigen::Map<const Eigen::VectorXd>(
      pose(all.back().measurement.real->keys().front()), point.size());
  GaussianSumInitializer bank({point});
  for (const double factor : {0.5, 1.0, 2.0}) {
    bank.add_candidates(ring_places(newest, factor * (point - newest).norm(),
                                    point.size() == 3 ? kDirections3 : kDirections2));
  }
  const auto count = std::min(all.size(), static_cast<std::size_t>(options.max_measurements));
  for (auto it = all.end() - static_cast<std::ptrdiff_t>(count); it != all.end(); ++it) {
    bank.add(it->measurement, options);
  }
  bank.refine(pose, options);
  double elsewhere = 0;
  for (const GaussianSumInitializer::Place& place : bank.places()) {
    const double off = (place.point - point).norm();
    if (off > options.max_sigma * place.distance) elsewhere += place.probability;
  }
  return elsewhere >= options.dominance &&
         2 * bank.places().front().explained > static_cast<double>(count);
}

/// Other places are tried each time that there are a tenth more measurements: while something
/// stands between, measurements are false for long, and no place explains them.
bool PlacedLandmarks::is_misplaced(std::int64_t id, Placed& landmark, const MapView& map,
                                   const BankOptions& options) {
  const std::size_t count = landmark.measurements.size();
  if (static_cast<double>(count) < kMore * static_cast<double>(landmark.asked)) return false;
  if (!is_doubtful(landmark, map.assignment, options)) return false;
  landmark.asked = count;
  const Eigen::VectorXd point =
      Eigen::Map<const Eigen::VectorXd>(map.values.data(position_key(id)), map.is_3d ? 3 : 2);
  return is_elsewhere(point, landmark, map, options);
}

Contribution PlacedLandmarks::take_out(const MapView& map, const BankOptions& options,
                                       const std::function<bool(std::int64_t)>& may_leave) {
  Contribution out;
  if (!map.keeps_all) {  // measurements outside the window are final
    placed_.clear();
    return out;
  }
  for (const std::int64_t id : touched_) {
    const auto it = placed_.find(id);
    if (it == placed_.end()) continue;
    const std::vector<Taken>& own = it->second.measurements;
    if (!std::all_of(own.begin(), own.end(), [&](const Taken& taken) {
          return map.holds(taken.measurement.real->keys().front());
        })) {
      placed_.erase(it);  // what has left the graph stays as it is
      continue;
    }
    if (!is_misplaced(id, it->second, map, options)) continue;
    if (may_leave && !may_leave(id)) continue;
    std::vector<Measurement>& measurements = restarts_[id];
    for (const Taken& taken : own) {
      out.delta.remove.push_back(taken.factor);
      measurements.push_back(taken.measurement);
    }
    const std::vector<Handle>& priors = it->second.priors;
    out.delta.remove.insert(out.delta.remove.end(), priors.begin(), priors.end());
    out.delta.remove_values.push_back(position_key(id));
    out.forgotten.push_back(id);
    change_.taken_out[id] = std::move(it->second);
    placed_.erase(it);
  }
  touched_.clear();
  return out;
}

std::vector<PlacedLandmarks::Measurement> PlacedLandmarks::restart(std::int64_t id) {
  const auto it = restarts_.find(id);
  if (it == restarts_.end()) return {};
  std::vector<Measurement> measurements = std::move(it->second);
  restarts_.erase(it);
  return measurements;
}

}  // namespace hybrid
