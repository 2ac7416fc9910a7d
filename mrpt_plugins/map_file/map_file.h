// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "libhybrid/io/write_lock.h"
#include "libhybrid/maps/map_record.h"

namespace SQLite {
class Database;
}

namespace HYBRID_API hybrid {

/// Reads a map file, a SQLite database as docs/map_format.md says. Throws Error that names the file
/// where it is missing, no map, damaged, of a later version of the format, or contradicts itself.
MapRecord read_map(const std::filesystem::path& file);

/// Whether a map has a checksum of its content, which `read_map` compares; those of formats before
/// 3 do not. Throws Error as `read_map`.
bool has_checksum(const std::filesystem::path& file);

/// Changes a map file; one process does at a time. Every method is one transaction: where it throws
/// (Error that names the file, as on a full disk) or the process dies, the file is as it was before
/// it.
class MapFile {
 public:
  /// Opens the file; a new one is there from its first change on. Throws Error as read_map does,
  /// and where another process writes it.
  explicit MapFile(std::filesystem::path file);
  ~MapFile();

  /// All that is in it; no sessions in a new one.
  const MapRecord& record() const { return record_; }

  /// Adds a session, incomplete and without keyframes, to the map of this dimension. Returns its
  /// number.
  int begin(const MapSession& session, bool is_3d);
  /// Replaces keyframes of a session, by number, and the landmarks that it sees so far.
  void note(int session, const std::vector<std::pair<std::size_t, MapKeyframe>>& keyframes,
            const std::vector<DraftLandmark>& landmarks);
  /// Replaces everything; where nothing changes, no byte of the file does. `before_commit` is
  /// called once everything is written and to commit needs no more room on the disk: where it
  /// throws, the file is as it was.
  void replace(const MapRecord& record, const std::function<void()>& before_commit = {});

 private:
  template <class Work>
  void transaction(const Work& work);
  void take_room();

  std::filesystem::path file_;
  std::filesystem::path made_;  // by this, and nothing is in it yet
  WriteLock lock_;
  std::unique_ptr<SQLite::Database> database_;
  MapRecord record_;
};

}  // namespace hybrid
