// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <SQLiteCpp/Database.h>
#include <SQLiteCpp/Exception.h>

#include <filesystem>
#include <memory>
#include <string>

#include "libhybrid/core/error.h"

/// Map files as databases that others may have made. Functions throw SQLite::Exception, and Error
/// as said, unless `about_map` gives these the name of the file.
namespace hybrid {

/// The file itself, behind all symbolic links, which need not be there yet. Throws Error that names
/// it where it is there, but no regular file.
std::filesystem::path map_path(const std::filesystem::path& file);

/// Opens a map with SQLite's limits set, so that nothing in it runs: an interrupted transaction is
/// rolled back where the file may be written.
std::unique_ptr<SQLite::Database> open_map(const std::filesystem::path& file, int flags);

/// Throws Error unless this is a map with the tables of its format, nothing else, and whole pages.
void check_map(SQLite::Database& database);

/// Whether a file is new, or was left by a process that died before its first transaction ended.
bool holds_nothing(SQLite::Database& database);

/// The value of a pragma that is a whole number.
int pragma(SQLite::Database& database, const char* name);

/// What SQLite says, in the words of who has the file.
Error explained(const std::filesystem::path& file, const SQLite::Exception& e);

/// What `work` returns; its errors name the file.
template <class Work>
auto about_map(const std::filesystem::path& file, const Work& work) {
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

/// Notes the checksum of the content: all rows but drafts and the keyframes of sessions that are
/// not complete. False where it is what was noted before.
bool note_checksum(SQLite::Database& database);

/// Throws Error where the content is not that of the checksum; files of formats before 3 have none.
void check_checksum(SQLite::Database& database);

}  // namespace hybrid
