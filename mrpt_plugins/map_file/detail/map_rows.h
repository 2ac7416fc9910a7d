// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <SQLiteCpp/Database.h>

#include <utility>
#include <vector>

#include "libhybrid/maps/map_record.h"

/// The rows of the tables of a map file. All throw SQLite::Exception.
namespace hybrid {

/// Reads all tables. Throws Error where they contradict each other, or are
/// not those of a map.
MapRecord read_rows(SQLite::Database& database);

/// Throws Error for a record that cannot be that of a map.
void refuse_faults(const MapRecord& record);

/// Makes the tables of a file those of `record`, where they were those of `before`.
void write_rows(SQLite::Database& database, const MapRecord& record, const MapRecord& before);

/// One session without its keyframes; and one keyframe and one draft, replaced or new.
void write_session(SQLite::Database& database, const MapSession& session);
void write_keyframes(SQLite::Database& database, int session,
                     const std::vector<std::pair<std::size_t, MapKeyframe>>& keyframes);
void write_drafts(SQLite::Database& database, const std::vector<DraftLandmark>& landmarks);

/// What clouds saw.
void write_local_clouds(SQLite::Database& database, const MapRecord& record);
void read_local_clouds(SQLite::Database& database, MapRecord& out);

/// How well local maps are known beside each other.
void write_parents(SQLite::Database& database, const MapRecord& record);
void read_parents(SQLite::Database& database, MapRecord& out);

/// What kind of map it is.
void write_kind(SQLite::Database& database, const MapRecord& record);

}  // namespace hybrid
