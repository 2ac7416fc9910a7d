// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/map_file/map_file.h"

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Exception.h>
#include <SQLiteCpp/Statement.h>
#include <SQLiteCpp/Transaction.h>
#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <string>
#include <utility>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/map_file/detail/map_rows.h"
#include "mrpt_plugins/map_file/detail/map_schema.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

constexpr int kPatience = 2000;  // [ms] for a reader to finish

constexpr const char* kEmpty = "is empty, not a map yet";

/// The text in one line.
std::string in_a_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

/// What SQLite says in the words of who has the file.
Error explained(const fs::path& file, const SQLite::Exception& e) {
  const std::string name = file.string() + ": ", what = in_a_line(e.what());
  switch (e.getErrorCode()) {
    case SQLITE_FULL:
      return Error(name + "no room left on its disk; the map is as it was");
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return Error(name + "another program is writing it; try again when it has ended");
    case SQLITE_NOTADB:
      return Error(name + "is no map: not a SQLite database");
    case SQLITE_CORRUPT:
      return Error(name + "is damaged: " + what + "; take a copy from before");
    case SQLITE_READONLY:
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
      return Error(name + "cannot be written: " + what);
    default:
      return Error(name + what);
  }
}

/// What `work` returns; its errors name the file.
template <class Work>
auto about_map(const fs::path& file, const Work& work) {
  try {
    return work();
  } catch (const SQLite::Exception& e) {
    throw explained(file, e);
  } catch (const Error& e) {
    const std::string message = e.what();
    if (message.rfind(file.string(), 0) == 0) throw;
    throw Error(file.string() + ": " + message);
  }
}

int pragma(SQLite::Database& database, const char* name) {
  return database.execAndGet(fmt::format("PRAGMA {}", name)).getInt();
}

/// Throws Error unless this is a map whose pages are whole.
void check(SQLite::Database& database) {
  const int id = pragma(database, "application_id"), version = pragma(database, "user_version");
  if (id != map_schema::kApplicationId) throw Error("is no map: a SQLite database of another kind");
  if (version < 1 || version > map_schema::kVersion) {
    throw Error(
        fmt::format("is a map of format {}, this program reads formats 1 to {}; use the version "
                    "that wrote it",
                    version, map_schema::kVersion));
  }
  const std::string whole = database.execAndGet("PRAGMA quick_check(1)").getString();
  if (whole != "ok") throw Error("is damaged: " + in_a_line(whole) + "; take a copy from before");
}

/// Opens for writing where that is allowed: an interrupted transaction is then rolled back.
std::unique_ptr<SQLite::Database> open(const fs::path& file, int flags) {
  auto database = std::make_unique<SQLite::Database>(file.string(), flags, kPatience);
  database->exec("PRAGMA foreign_keys = ON");
  return database;
}

void refuse_folder(const fs::path& file) {
  std::error_code unknown;
  if (fs::is_directory(file, unknown)) throw Error(file.string() + ": is a folder, not a map");
}

/// Whether a file is new, or was left by a process that died before its first transaction ended.
bool holds_nothing(SQLite::Database& database) {
  return pragma(database, "page_count") == 0;
}

fs::path lock_of(const fs::path& file) {
  return file.parent_path() / ("." + file.filename().string() + ".lock");
}

}  // namespace

MapRecord read_map(const fs::path& file) {
  std::error_code unknown;
  if (!fs::exists(file, unknown)) throw Error(file.string() + ": no such map");
  refuse_folder(file);
  return about_map(file, [&] {
    std::unique_ptr<SQLite::Database> database;
    try {
      database = open(file, SQLite::OPEN_READWRITE);
    } catch (const SQLite::Exception&) {
      database = open(file, SQLite::OPEN_READONLY);
    }
    if (holds_nothing(*database)) throw Error(kEmpty);
    check(*database);
    SQLite::Transaction snapshot(*database);
    return read_rows(*database);
  });
}

MapFile::MapFile(fs::path file) : file_(std::move(file)), lock_(lock_of(file_), file_) {
  refuse_folder(file_);
  const bool fresh = about_map(file_, [&] {
    database_ = open(file_, SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
    if (holds_nothing(*database_)) return true;
    check(*database_);
    record_ = read_rows(*database_);
    return false;
  });
  if (!fresh) return;
  transaction([&] {
    database_->exec(map_schema::kTables);
    database_->exec(fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}",
                                map_schema::kApplicationId, map_schema::kVersion));
    write_kind(*database_, record_);
  });
}

MapFile::~MapFile() = default;

template <class Work>
void MapFile::transaction(const Work& work) {
  about_map(file_, [&] {
    SQLite::Transaction all(*database_, SQLite::TransactionBehavior::IMMEDIATE);
    if (pragma(*database_, "user_version") == 1) database_->exec(map_schema::kFromVersion1);
    work();
    all.commit();
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
  });
}

void MapFile::replace(const MapRecord& record, const std::function<void()>& before_commit) {
  transaction([&] {
    write_rows(*database_, record);
    if (before_commit) before_commit();
  });
  record_ = record;
}

}  // namespace hybrid
