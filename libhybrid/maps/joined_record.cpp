// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/maps/detail/joined_record.h"

#include <algorithm>
#include <array>
#include <map>

#include "libhybrid/geometry/isometry.h"
#include "libhybrid/maps/sparse_gaussian.h"

namespace hybrid {
namespace {

/// A landmark of the joint map, and its variable.
struct JoinedLandmark {
  MapLandmark landmark;
  Key key;
};

/// What two maps say of the class of a landmark: the prior of the second counts in both.
std::vector<double> class_belief(const std::vector<double>& p, const std::vector<double>& q,
                                 const std::vector<double>& prior_of_q) {
  if (p.size() != q.size()) return p.empty() ? q : p;
  const bool uniform = prior_of_q.size() != q.size();
  std::vector<double> out(p.size());
  double sum = 0;
  for (std::size_t c = 0; c < p.size(); ++c) {
    const double prior = uniform ? 1.0 : prior_of_q[c];
    out[c] = prior > 0 ? p[c] * q[c] / prior : 0.0;
    sum += out[c];
  }
  for (double& v : out) v = sum > 0 ? v / sum : 1.0 / static_cast<double>(p.size());
  return out;
}

/// The prior of the classes of a landmark that a session made.
std::vector<double> class_prior(const MapRecord& map, int session) {
  for (const MapSession& s : map.sessions) {
    if (s.id == session) return s.class_prior;
  }
  return {};
}

/// Whether the second of two landmarks with one id is the one to keep: what is there rather than
/// what is not, what was seen more often rather than what was seen less.
bool prefers_second(const MapLandmark& a, const MapLandmark& b) {
  if (exists(a) != exists(b)) return exists(b);
  return b.sightings > a.sightings;
}

/// Of a motion in the plane, from that of a motion in the plane or in space.
SE2::Jacobian planar_covariance(const Eigen::MatrixXd& covariance) {
  if (covariance.rows() == SE2::kDim) return covariance;
  const std::array<int, 3> at{0, 1, 5};  // x, y, and the turn about z
  return covariance(at, at);
}

/// A local map of the second map in the frame of the first. As if its error and that of the motion
/// between the maps were independent.
MapLocalMap moved(MapLocalMap local, const SE2& T, const SE2::Jacobian& covariance) {
  const SE2 before(local.pose.x(), local.pose.y(), local.pose.z());
  const SE2 pose = T * before;
  const SE2::Jacobian Ad = before.inverse().adjoint();
  local.pose << pose.x(), pose.y(), pose.angle();
  local.covariance += Ad * covariance * Ad.transpose();
  return local;
}

/// The same of a local cloud.
MapLocalCloud moved(MapLocalCloud local, const Eigen::Isometry3d& T,
                    const Eigen::MatrixXd& covariance) {
  UncertainMotion3 motion{to_se3(T), SE3::Jacobian::Zero()};
  if (covariance.rows() == SE3::kDim) motion.covariance = covariance;
  UncertainMotion3& anchor = local.T_map_anchor;
  anchor = motion * anchor;
  return local;
}

template <class Pose>
std::vector<JoinedLandmark> landmarks_of_both(const MapRecord& first, const MapRecord& second,
                                              int shift, const LandmarkPairs& pairs,
                                              const JointEstimate<Pose>& joint, JoinedMaps& out) {
  std::vector<JoinedLandmark> all;
  std::map<std::int64_t, std::size_t> of_id;
  std::map<int, int> partner;
  for (const auto& [i, j] : pairs) partner[j] = i;
  std::int64_t next = 0;
  for (std::size_t i = 0; i < first.landmarks.size(); ++i) {
    of_id[first.landmarks[i].id] = all.size();
    all.push_back({first.landmarks[i], joint.first(static_cast<int>(i))});
    next = std::max(next, first.landmarks[i].id + 1);
  }
  for (std::size_t j = 0; j < second.landmarks.size(); ++j) {
    MapLandmark l = second.landmarks[j];
    const Key key = joint.second(static_cast<int>(j));
    if (const auto pair = partner.find(static_cast<int>(j)); pair != partner.end()) {
      MapLandmark& known = all[static_cast<std::size_t>(pair->second)].landmark;
      known.sightings += l.sightings;
      known.existence = std::max(known.existence, l.existence);
      known.size.extent = std::max(known.size.extent, l.size.extent);
      known.size.things = std::max(known.size.things, l.size.things);
      known.class_probabilities = class_belief(known.class_probabilities, l.class_probabilities,
                                               class_prior(second, l.session));
      continue;
    }
    if (!out.map.identified) l.id = next++;
    l.session += shift;
    const auto other = of_id.find(l.id);
    if (other == of_id.end()) {
      all.push_back({l, key});
      continue;
    }
    JoinedLandmark& known = all[other->second];
    const bool replaces = prefers_second(known.landmark, l);
    if (exists(known.landmark) && exists(l)) {
      out.contradictions.push_back({l.id, (joint.at(known.key) - joint.at(key)).norm(), !replaces});
    }
    if (replaces) known = {l, key};
  }
  std::stable_sort(all.begin(), all.end(), [](const JoinedLandmark& x, const JoinedLandmark& y) {
    return x.landmark.id < y.landmark.id;
  });
  return all;
}

}  // namespace

template <class Pose>
void record_join(const MapRecord& first, const MapRecord& second, const LandmarkPairs& pairs,
                 const JointEstimate<Pose>& joint, JoinedMaps& out) {
  constexpr int kDim = Pose::Point::RowsAtCompileTime;
  MapRecord& map = out.map;
  map.is_3d = first.is_3d;
  // A map without landmarks does not tell of what kind they are.
  const MapRecord& kind = first.landmarks.empty() ? second : first;
  map.identified = kind.identified;
  map.class_names = kind.class_names;
  map.origin = first.origin;
  map.sessions = first.sessions;
  const int shift = first.sessions.empty() ? 0 : first.sessions.back().id;
  for (MapSession session : second.sessions) {
    session.id += shift;
    for (MapKeyframe& k : session.keyframes) k.T_map_robot = out.T_first_second * k.T_map_robot;
    map.sessions.push_back(std::move(session));
  }
  map.local_maps = first.local_maps;
  const SE2 T = to_se2(out.T_first_second);
  const SE2::Jacobian covariance = planar_covariance(out.covariance);
  for (MapLocalMap local : second.local_maps) {
    local.session += shift;
    if (local.parent) local.parent->place += first.local_maps.size();
    map.local_maps.push_back(moved(std::move(local), T, covariance));
  }
  map.local_clouds = first.local_clouds;
  for (MapLocalCloud local : second.local_clouds) {
    local.session += shift;
    if (local.T_map_anchor.parent) local.T_map_anchor.parent->place += first.local_clouds.size();
    map.local_clouds.push_back(moved(std::move(local), out.T_first_second, out.covariance));
  }
  std::vector<Key> keys;
  const Covariances covariances = joint.marginals().all();
  for (JoinedLandmark& l : landmarks_of_both(first, second, shift, pairs, joint, out)) {
    l.landmark.position.template head<kDim>() = joint.at(l.key);
    l.landmark.covariance.setZero();
    l.landmark.covariance.template topLeftCorner<kDim, kDim>() = covariances.at(l.key);
    map.landmarks.push_back(std::move(l.landmark));
    keys.push_back(l.key);
  }
  map.prior = sparsify(joint.graph(), joint.values(), keys, kDim);
}

template void record_join(const MapRecord&, const MapRecord&, const LandmarkPairs&,
                          const JointEstimate<SE2>&, JoinedMaps&);
template void record_join(const MapRecord&, const MapRecord&, const LandmarkPairs&,
                          const JointEstimate<SE3>&, JoinedMaps&);

}  // namespace hybrid
