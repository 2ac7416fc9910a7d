// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/session/map_run.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/io/regular_file.h"
#include "mrpt_plugins/bridge/interrupt.h"
#include "mrpt_plugins/bridge/sha256.h"
#include "mrpt_plugins/map_file/export_map.h"
#include "mrpt_plugins/rawlog/decoder.h"

namespace hybrid {
namespace {

constexpr double kSure = 12;     // log odds of a landmark whose existence no plugin judges
constexpr double kSame = 1e-6;   // by which coordinates of one run may differ in two
constexpr double kMoved = 1e-9;  // from which on a pose is written again

const char* space_of(bool is_3d) {
  return is_3d ? "in space" : "in the plane";
}

double apart(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff();
}

/// Of what a log holds, decompressed, so that it is known again however it is compressed, as far as
/// it is read; empty for what is no regular file.
std::string content_hash(const std::string& path) {
  if (!std::filesystem::is_regular_file(path)) return "";
  RegularFile file(path);
  Decoder decoder([&](char* to, std::size_t count) { return file.read(to, count); });
  return sha256_of([&](char* to, std::size_t count) { return decoder.read(to, count); });
}

MapSession session_of(const Provenance& provenance, const std::vector<std::string>& logs) {
  MapSession session;
  session.version = provenance.version;
  session.command = fmt::format("{}", fmt::join(provenance.command, " "));
  const auto start = summary_start("", "", provenance);
  if (start.contains("configuration")) session.configuration = start["configuration"].dump();
  for (const Provenance::Input& input : provenance.inputs) {
    const bool is_log = std::find(logs.begin(), logs.end(), input.path) != logs.end();
    session.inputs.emplace_back(input.path, is_log ? content_hash(input.path) : input.sha256);
  }
  return session;
}

std::vector<DraftLandmark> drafts(const Mapper& mapper) {
  std::vector<DraftLandmark> out;
  for (const auto& [id, landmark] : mapper.landmarks()) {
    DraftLandmark draft{
        id, point_at(mapper.backend().values(), landmark.position), {}, landmark.sightings};
    if (landmark.class_key) {
      draft.class_index = mapper.backend().assignment().at(landmark.class_key->key);
    }
    out.push_back(draft);
  }
  return out;
}

}  // namespace

MapRecord record_of(const Mapper& mapper, const MapResult& result) {
  MapRecord out;
  out.is_3d = mapper.is_3d();
  out.class_names = result.class_names;
  out.identified = mapper.decisions().empty();
  const auto existence = mapper.existence();
  std::vector<Key> keys;
  for (const LandmarkEstimate& estimate : result.landmarks) {
    MapLandmark landmark;
    landmark.id = estimate.id;
    landmark.position = estimate.position;
    landmark.covariance = estimate.covariance;
    landmark.class_probabilities = estimate.class_probabilities;
    landmark.sightings = estimate.sightings;
    landmark.size = estimate.size;
    const auto it = existence.find(estimate.id);
    landmark.existence = it == existence.end() ? kSure : it->second;
    out.landmarks.push_back(std::move(landmark));
    keys.push_back(mapper.landmarks().find(estimate.id)->position);
  }
  if (!keys.empty()) {
    out.prior = sparsify(mapper.backend().joint_covariance(keys), out.dim());
  }
  return out;
}

MapRun::MapRun(const MapOptions& options, const Provenance& provenance,
               const std::vector<std::string>& logs, bool resume, bool is_3d)
    : options_(options), session_(session_of(provenance, logs)), is_3d_(is_3d) {
  for (const Provenance::Input& input : provenance.inputs) hashes_.push_back(input.sha256);
  session_.mode = options_.mode;
  if (options_.localizes()) {
    if (resume) throw Error(options_.file + ": nothing to resume: localize leaves it as it is");
    map_ = read_map(options_.file);
  } else {
    file_ = std::make_unique<MapFile>(options_.file);
    map_ = file_->record();
  }
  try {
    choose_mode(logs, resume);
  } catch (const Error& e) {
    throw Error(options_.file + ": " + e.what());
  }
}

/// Whether a session is of the same log under the same settings. What came through standard input
/// has no hash to tell.
bool MapRun::same_run(const MapSession& other) const {
  if (other.configuration != session_.configuration ||
      other.inputs.size() != session_.inputs.size()) {
    return false;
  }
  for (std::size_t i = 0; i < session_.inputs.size(); ++i) {
    if (!same_input(i, other.inputs[i].second)) return false;
  }
  return true;
}

/// Whether an input has this hash: of its content, or, as earlier versions wrote, of the file.
bool MapRun::same_input(std::size_t i, const std::string& sha256) const {
  return !sha256.empty() && (sha256 == session_.inputs[i].second || sha256 == hashes_[i]);
}

/// Throws Error where a log is in the map already.
void MapRun::refuse_again(const std::vector<std::string>& logs) const {
  for (std::size_t i = 0; i < session_.inputs.size(); ++i) {
    const std::string& path = session_.inputs[i].first;
    if (std::find(logs.begin(), logs.end(), path) == logs.end()) continue;
    for (const MapSession& s : map_.sessions) {
      const bool known = std::any_of(s.inputs.begin(), s.inputs.end(), [&](const auto& input) {
        return same_input(i, input.second);
      });
      if (!known) continue;
      throw Error(fmt::format("session {} mapped {} already: what it measured would count twice",
                              s.id, path));
    }
  }
}

void MapRun::choose_mode(const std::vector<std::string>& logs, bool resume) {
  auto& sessions = map_.sessions;
  if (!sessions.empty() && map_.is_3d != is_3d_) {
    throw Error(fmt::format("is a map {}, but the log is {}; [map] dimension = {} may help",
                            space_of(map_.is_3d), space_of(is_3d_), map_.dim()));
  }
  const bool open = !sessions.empty() && !sessions.back().complete;
  if (open && !options_.localizes()) {
    const MapSession last = sessions.back();
    if (!resume) {
      throw Error(
          fmt::format("session {} was interrupted after {} keyframes; --resume goes on "
                      "with it, and 'hybrid-map prune --session {}' removes it",
                      last.id, last.keyframes.size(), last.id));
    }
    if (!same_run(last)) {
      throw Error(
          fmt::format("session {} was of other files or other settings ('{}'); resume it "
                      "with those",
                      last.id, last.command));
    }
    if (options_.mode != "auto" && options_.mode != last.mode) {
      throw Error(fmt::format("session {} is to {}, not to {}", last.id, last.mode, options_.mode));
    }
    session_ = last;
    resumed_ = last;
    sessions.pop_back();
  } else if (resume && !sessions.empty() && same_run(sessions.back())) {
    throw Error(fmt::format("nothing to resume: session {} is complete", sessions.back().id));
  }
  if (session_.mode == "auto") session_.mode = sessions.empty() ? "build" : "extend";
  if (session_.mode == "build" && !sessions.empty()) {
    throw Error("holds a map already; extend it, or build in another file");
  }
  if (session_.mode != "build" && !holds_places(map_)) {
    throw Error(fmt::format("holds no landmark and no laser scans to {} from; build it first",
                            session_.mode));
  }
  if (session_.mode == "extend" && !resumed_) refuse_again(logs);
}

void MapRun::begin(const std::vector<std::string>& robots) {
  if (!file_) return;
  begun_ = true;
  session_.robots = robots;
  if (!resumed_) session_.id = file_->begin(session_, is_3d_);
}

MapKeyframe MapRun::keyframe(const Mapper& mapper, std::size_t i) const {
  return {mapper.log_rows()[i], mapper.time_of(i), mapper.robot_of(i),
          isometry_at(mapper.backend().values(), Key(key_letter::kPose, i))};
}

void MapRun::added(const Mapper& mapper) {
  if (!begun_) return;
  const std::size_t n = mapper.log_rows().size();
  if (resumed_) {
    if (n < resumed_->keyframes.size()) return;  // these are in the file
    compare(mapper);
    written_ = resumed_->keyframes;
    resumed_.reset();
  }
  if (n % static_cast<std::size_t>(options_.commit_every) == 0) pause(mapper);
}

/// Where the same log gives other poses than before, it is another program that maps it.
void MapRun::compare(const Mapper& mapper) const {
  for (std::size_t i = 0; i < resumed_->keyframes.size(); ++i) {
    const Eigen::Isometry3d now = keyframe(mapper, i).T_map_robot;
    if (apart(now, resumed_->keyframes[i].T_map_robot) < kSame) continue;
    throw Error(
        fmt::format("{}: keyframe {} of session {} does not come out as it was; resume it "
                    "with version {}, or 'hybrid-map prune' it",
                    options_.file, i, session_.id, session_.version));
  }
}

void MapRun::pause(const Mapper& mapper) {
  if (!begun_ || resumed_) return;
  std::vector<std::pair<std::size_t, MapKeyframe>> changed;
  for (std::size_t i = 0; i < mapper.log_rows().size(); ++i) {
    const MapKeyframe now = keyframe(mapper, i);
    if (i < written_.size() && apart(now.T_map_robot, written_[i].T_map_robot) < kMoved) continue;
    changed.emplace_back(i, now);
  }
  write([&] { file_->note(session_.id, changed, drafts(mapper)); });
  for (const auto& [i, k] : changed) {
    if (i == written_.size()) {
      written_.push_back(k);
    } else {
      written_[i] = k;
    }
  }
}

void MapRun::finish(const Mapper& mapper, const MapResult& result, const SeenPlaces& seen,
                    const std::function<void()>& before_commit) {
  if (!begun_) {
    before_commit();
    return;
  }
  MapRecord record = after(mapper, result);
  record.local_maps = map_.local_maps;
  for (MapLocalMap local : seen.local_maps) {
    local.session = session_.id;
    record.local_maps.push_back(std::move(local));
  }
  record.local_clouds = map_.local_clouds;
  for (MapLocalCloud local : seen.local_clouds) {
    local.session = session_.id;
    record.local_clouds.push_back(std::move(local));
  }
  write([&] { file_->replace(record, before_commit); });
}

void MapRun::give_up() {
  if (begun_) file_->replace(map_);
  begun_ = false;
}

/// Errors say that the session is in the file, too.
template <class Work>
void MapRun::write(const Work& work) const {
  try {
    work();
  } catch (const Interrupted&) {
    throw;
  } catch (const Error& e) {
    throw Error(
        fmt::format("{}; session {} is interrupted: --resume goes on with it, 'hybrid-map "
                    "prune --session {}' removes it",
                    e.what(), session_.id, session_.id));
  }
}

MapRecord MapRun::after(const Mapper& mapper, const MapResult& result) const {
  MapRecord out = record_of(mapper, result);
  // A session without detections does not change what the ids are.
  if (!map_.landmarks.empty()) out.identified = map_.identified;
  out.sessions = map_.sessions;
  out.origin = options_.origin ? options_.origin : map_.origin;
  if (!out.origin && result.datum && result.datum->is_on_earth) {
    out.origin = origin_of(*result.datum);
  }
  for (MapLandmark& landmark : out.landmarks) {
    const auto known = std::find_if(map_.landmarks.begin(), map_.landmarks.end(),
                                    [&](const MapLandmark& l) { return l.id == landmark.id; });
    landmark.session = known == map_.landmarks.end() ? session_.id : known->session;
  }
  MapSession session = session_;
  session.complete = true;
  session.keyframes.clear();
  for (std::size_t i = 0; i < mapper.log_rows().size(); ++i) {
    session.keyframes.push_back(keyframe(mapper, i));
  }
  out.sessions.push_back(std::move(session));
  return out;
}

}  // namespace hybrid
