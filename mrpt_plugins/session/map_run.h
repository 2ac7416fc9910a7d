// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mrpt_plugins/bridge/provenance.h"
#include "mrpt_plugins/map_file/map_file.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/session/scan_places.h"
#include "mrpt_plugins/settings/map_options.h"

namespace HYBRID_API hybrid {

/// What a mapper has found as a map: landmarks, and what is known of them together. Without
/// sessions.
MapRecord record_of(const Mapper& mapper, const MapResult& result);

/// A replay's session in a map file.
class MapRun {
 public:
  /// Reads the map and decides the mode; `logs` are those of the robots. Throws Error, which names
  /// the file, where map, mode, logs and what is to be resumed do not go together; the file is then
  /// as it was.
  MapRun(const MapOptions& options, const Provenance& provenance,
         const std::vector<std::string>& logs, bool resume, bool is_3d);

  /// build, extend or localize.
  const std::string& mode() const { return session_.mode; }
  /// The map before the session.
  const MapRecord& map() const { return map_; }
  bool localizes() const { return session_.mode == "localize"; }

  /// Enters the session into the file, unless the mode leaves that as it is. From now on every
  /// so many keyframes are written. `robots` are the names of those that there are.
  void begin(const std::vector<std::string>& robots);
  /// Tells that the mapper took one more keyframe in. Throws Error where an interrupted session
  /// does not come out as it was.
  void added(const Mapper& mapper);
  /// Writes what has not been written yet.
  void pause(const Mapper& mapper);
  /// Replaces the map by that after the session, which has `seen` these places. `before_commit` is
  /// called when all is written and nothing shows yet.
  void finish(const Mapper& mapper, const MapResult& result, const SeenPlaces& seen,
              const std::function<void()>& before_commit);
  /// Takes back what was written of the session: the robot is not in the map after all.
  void give_up();

 private:
  template <class Work>
  void write(const Work& work) const;
  void choose_mode(const std::vector<std::string>& logs, bool resume);
  void refuse_again(const std::vector<std::string>& logs) const;
  bool same_run(const MapSession& other) const;
  bool same_input(std::size_t i, const std::string& sha256) const;
  void compare(const Mapper& mapper) const;
  MapKeyframe keyframe(const Mapper& mapper, std::size_t i) const;
  MapRecord after(const Mapper& mapper, const MapResult& result) const;

  MapOptions options_;
  MapSession session_;
  std::vector<std::string> hashes_;  // of its input files as they are
  MapRecord map_;
  bool is_3d_;
  std::unique_ptr<MapFile> file_;
  std::optional<MapSession> resumed_;  // as it was when it was interrupted
  std::vector<MapKeyframe> written_;
  bool begun_ = false;
};

}  // namespace hybrid
