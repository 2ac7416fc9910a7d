// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/map_file/detail/map_database.h"

#include <SQLiteCpp/Statement.h>
#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <cctype>
#include <vector>

#include "mrpt_plugins/map_file/detail/map_schema.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

constexpr int kPatience = 2000;            // [ms] for a reader to finish
constexpr int kLongestCell = 16 << 20;     // [bytes], some eight times the longest command of Linux
constexpr int kLongestStatement = 100000;  // [bytes], among them those that make the tables
constexpr int kMostLinks = 40;             // that Linux follows

/// The text in one line, without control characters, which a damaged file puts into messages.
std::string in_a_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return std::iscntrl(c) != 0; }, ' ');
  return text;
}

/// With one space for each run of them.
std::string with_single_spaces(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const bool space = std::isspace(static_cast<unsigned char>(c)) != 0;
    if (!space || out.empty() || out.back() != ' ') out += space ? ' ' : c;
  }
  return out;
}

/// What a database is made of, sorted; no more than `most` of it.
std::vector<std::string> parts_of(SQLite::Database& database, std::size_t most) {
  std::vector<std::string> parts;
  SQLite::Statement rows(database, "SELECT type, name, tbl_name, sql FROM sqlite_master");
  while (parts.size() < most && rows.executeStep()) {
    parts.push_back(fmt::format("{} {} of {}: {}", rows.getColumn(0).getString(),
                                rows.getColumn(1).getString(), rows.getColumn(2).getString(),
                                with_single_spaces(rows.getColumn(3).getString())));
  }
  std::sort(parts.begin(), parts.end());
  return parts;
}

void check_tables(SQLite::Database& database, int version) {
  SQLite::Database sound(":memory:", SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
  sound.exec(map_schema::kTables);
  if (version >= map_schema::kFirstWithScans) sound.exec(map_schema::kScanTables);
  if (version >= map_schema::kFirstWithSizes) sound.exec(map_schema::kSizeTable);
  if (version >= map_schema::kFirstWithClouds) sound.exec(map_schema::kCloudTable);
  if (version >= map_schema::kFirstWithParents) sound.exec(map_schema::kParentTable);
  if (version == 1) sound.exec(map_schema::kToVersion1);
  const std::vector<std::string> right = parts_of(sound, 1000);
  if (parts_of(database, right.size() + 1) == right) return;
  throw Error("is no map: holds other tables, views or triggers than a map");
}

}  // namespace

fs::path map_path(const fs::path& file) {
  if (file.empty()) throw Error("the map file has no name; name one, such as park.hmap");
  std::error_code unknown;
  fs::path path = file;
  for (int i = 0; i < kMostLinks && fs::is_symlink(path, unknown); ++i) {
    path = path.parent_path() / fs::read_symlink(path, unknown);
  }
  const auto refuse = [&](const char* what) -> Error { return Error(file.string() + what); };
  switch (fs::status(path, unknown).type()) {
    case fs::file_type::regular:
    case fs::file_type::not_found:
    case fs::file_type::unknown:
    case fs::file_type::none:
      break;
    case fs::file_type::directory:
      throw refuse(": is a folder, not a map");
    case fs::file_type::fifo:
      throw refuse(": is a pipe, not a map file");
    default:
      throw refuse(": is a device, not a map file");
  }
  // Absolute, since SQLite takes some names, such as :memory:, for databases that are no files.
  const fs::path full = fs::absolute(path, unknown);
  const fs::path whole = fs::weakly_canonical(full, unknown);
  return unknown || whole.empty() ? path : whole;
}

std::unique_ptr<SQLite::Database> open_map(const fs::path& file, int flags) {
  std::error_code unknown;
  // SQLite takes a file of one byte for an empty one.
  if (fs::file_size(file, unknown) == 1) throw Error("is no map: not a SQLite database");
  auto database = std::make_unique<SQLite::Database>(file.string(), flags, kPatience);
  sqlite3* handle = database->getHandle();
  sqlite3_limit(handle, SQLITE_LIMIT_LENGTH, kLongestCell);
  sqlite3_limit(handle, SQLITE_LIMIT_SQL_LENGTH, kLongestStatement);
  sqlite3_limit(handle, SQLITE_LIMIT_ATTACHED, 0);
  for (const auto& [option, on] : {std::pair{SQLITE_DBCONFIG_DEFENSIVE, 1},
                                   {SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0},
                                   {SQLITE_DBCONFIG_ENABLE_TRIGGER, 0},
                                   {SQLITE_DBCONFIG_ENABLE_VIEW, 0}}) {
    sqlite3_db_config(handle, option, on, nullptr);
  }
  database->exec("PRAGMA foreign_keys = ON; PRAGMA cell_size_check = ON; PRAGMA mmap_size = 0");
  return database;
}

int pragma(SQLite::Database& database, const char* name) {
  return database.execAndGet(fmt::format("PRAGMA {}", name)).getInt();
}

bool holds_nothing(SQLite::Database& database) {
  return pragma(database, "page_count") == 0;
}

void check_map(SQLite::Database& database) {
  const int id = pragma(database, "application_id"), version = pragma(database, "user_version");
  if (id != map_schema::kApplicationId) throw Error("is no map: a SQLite database of another kind");
  if (version < 1 || version > map_schema::kVersion) {
    throw Error(
        fmt::format("is a map of format {}, this program reads formats 1 to {}; use the version "
                    "that wrote it",
                    version, map_schema::kVersion));
  }
  check_tables(database, version);
  const std::string whole = database.execAndGet("PRAGMA quick_check(1)").getString();
  if (whole != "ok") throw Error("is damaged: " + in_a_line(whole) + "; take a copy from before");
}

Error explained(const fs::path& file, const SQLite::Exception& e) {
  const std::string name = file.string() + ": ", what = in_a_line(e.what());
  const char* const left = "; this change is not written";
  switch (e.getErrorCode() & 0xff) {  // of extended codes the primary one
    case SQLITE_FULL:
      return Error(name + "no room left on its disk" + left);
    case SQLITE_IOERR:
      return Error(name + what + " (is a limit of the size of files reached?)" + left);
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return Error(name + "another program is writing it; try again when it has ended");
    case SQLITE_NOTADB:
      return Error(name + "is no map: not a SQLite database");
    case SQLITE_CORRUPT:
      return Error(name + "is damaged: " + what + "; take a copy from before");
    case SQLITE_TOOBIG:
      return Error(
          fmt::format("{}is no map: holds a text of more than {} bytes", name, kLongestCell));
    case SQLITE_READONLY:
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
      return Error(name + "cannot be written: " + what);
    default:
      return Error(name + what);
  }
}

}  // namespace hybrid
