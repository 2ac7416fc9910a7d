// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/map_file/map_file.h"

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Exception.h>
#include <SQLiteCpp/Transaction.h>
#include <fmt/format.h>
#include <sqlite3.h>

#include <string>
#include <utility>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/map_file/detail/map_database.h"
#include "mrpt_plugins/map_file/detail/map_rows.h"
#include "mrpt_plugins/map_file/detail/map_schema.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

constexpr const char* kEmpty = "is empty, not a map yet";

fs::path lock_of(const fs::path& file) {
  return file.parent_path() / ("." + file.filename().string() + ".lock");
}

/// Throws Error for a file of several names: SQLite rolls back by the name.
void refuse_hard_links(const fs::path& file) {
  std::error_code unknown;
  if (fs::hard_link_count(file, unknown) <= 1 || unknown) return;
  throw Error("has several names (hard links), each of which would be written apart; copy it");
}

}  // namespace

MapRecord read_map(const fs::path& file) {
  std::error_code unknown;
  if (!fs::exists(file, unknown)) throw Error(file.string() + ": no such map");
  const fs::path path = map_path(file);
  return about_map(file, [&] {
    std::unique_ptr<SQLite::Database> database;
    try {
      database = open_map(path, SQLite::OPEN_READWRITE);
    } catch (const SQLite::Exception&) {
      database = open_map(path, SQLite::OPEN_READONLY);
    }
    if (holds_nothing(*database)) throw Error(kEmpty);
    check_map(*database);
    SQLite::Transaction snapshot(*database);
    return read_rows(*database);
  });
}

bool has_checksum(const fs::path& file) {
  const fs::path path = map_path(file);
  return about_map(file, [&] {
    const auto database = open_map(path, SQLite::OPEN_READONLY);
    check_map(*database);
    return pragma(*database, "user_version") >= map_schema::kFirstWithChecksum;
  });
}

MapFile::MapFile(fs::path file) : file_(std::move(file)), lock_(lock_of(map_path(file_)), file_) {
  about_map(file_, [&] {
    const fs::path path = map_path(file_);
    refuse_hard_links(path);
    std::error_code unknown;
    if (!fs::exists(path, unknown)) made_ = path;
    database_ = open_map(path, SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
    if (holds_nothing(*database_)) return;
    check_map(*database_);
    record_ = read_rows(*database_);
  });
}

MapFile::~MapFile() {
  database_.reset();
  std::error_code unknown;
  if (made_.empty()) return;
  fs::remove(made_, unknown);
  fs::remove(made_ += "-journal", unknown);  // of a change that could not be written
}

/// Commits what `work` does where it returns true.
template <class Work>
void MapFile::transaction(const Work& work) {
  about_map(file_, [&] {
    SQLite::Transaction all(*database_, SQLite::TransactionBehavior::IMMEDIATE);
    const int version = pragma(*database_, "user_version");
    if (version == 0) {
      database_->exec(map_schema::kTables);
      database_->exec(fmt::format("PRAGMA application_id = {}", map_schema::kApplicationId));
      write_kind(*database_, record_);
    }
    if (version == 1) database_->exec(map_schema::kFromVersion1);
    if (version < map_schema::kFirstWithScans) database_->exec(map_schema::kScanTables);
    if (version < map_schema::kFirstWithSizes) database_->exec(map_schema::kSizeTable);
    if (version < map_schema::kFirstWithClouds) database_->exec(map_schema::kCloudTable);
    if (version < map_schema::kFirstWithParents) database_->exec(map_schema::kParentTable);
    database_->exec(fmt::format("PRAGMA user_version = {}", map_schema::kVersion));
    if (!work()) return;
    all.commit();
    made_.clear();
  });
}

int MapFile::begin(const MapSession& session, bool is_3d) {
  MapRecord record = record_;
  record.is_3d = is_3d;
  MapSession added = session;
  added.id = record.sessions.empty() ? 1 : record.sessions.back().id + 1;
  added.complete = false;
  added.keyframes.clear();
  transaction([&] {
    write_kind(*database_, record);
    write_session(*database_, added);
    write_drafts(*database_, {});
    return note_checksum(*database_);
  });
  record.sessions.push_back(added);
  record_ = std::move(record);
  return added.id;
}

void MapFile::note(int session, const std::vector<std::pair<std::size_t, MapKeyframe>>& keyframes,
                   const std::vector<DraftLandmark>& landmarks) {
  transaction([&] {
    write_keyframes(*database_, session, keyframes);
    write_drafts(*database_, landmarks);
    return true;
  });
}

void MapFile::replace(const MapRecord& record, const std::function<void()>& before_commit) {
  about_map(file_, [&] { refuse_faults(record); });
  transaction([&] {
    write_rows(*database_, record, record_);
    const bool changed = note_checksum(*database_);
    if (changed) take_room();
    if (before_commit) before_commit();
    return changed;
  });
  record_ = record;
}

/// Writes all pages of a transaction that go beyond what the file and its journal have, so that to
/// commit needs no room on the disk.
void MapFile::take_room() {
  const int code = sqlite3_db_cacheflush(database_->getHandle());
  if (code != SQLITE_OK) throw SQLite::Exception(sqlite3_errstr(code), code);
}

}  // namespace hybrid
