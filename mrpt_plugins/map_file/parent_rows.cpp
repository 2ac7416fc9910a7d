// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <SQLiteCpp/Statement.h>
#include <fmt/format.h>

#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "mrpt_plugins/map_file/detail/map_cells.h"
#include "mrpt_plugins/map_file/detail/map_database.h"
#include "mrpt_plugins/map_file/detail/map_rows.h"
#include "mrpt_plugins/map_file/detail/map_schema.h"

namespace hybrid {
namespace {

/// Session, and number in it, by which rows name local maps.
using RowName = std::pair<int, std::int64_t>;

template <class Local>
std::vector<RowName> names_of(const std::vector<Local>& all) {
  std::vector<RowName> out;
  std::map<int, std::int64_t> count;  // by session
  for (const Local& local : all) out.emplace_back(local.session, count[local.session]++);
  return out;
}

template <class Local>
auto& parent_of(Local& local) {
  if constexpr (std::is_same_v<std::remove_const_t<Local>, MapLocalMap>) {
    return local.parent;
  } else {
    return local.T_map_anchor.parent;
  }
}

template <class Local>
void write_parents(SQLite::Database& database, const std::vector<Local>& all) {
  SQLite::Statement row(database, "INSERT INTO place_parent VALUES (?, ?, ?, ?, ?)");
  const std::vector<RowName> names = names_of(all);
  for (std::size_t m = 0; m < all.size(); ++m) {
    const auto& parent = parent_of(all[m]);
    if (!parent) continue;
    row.bind(1, names[m].first);
    row.bind(2, names[m].second);
    row.bind(3, names[parent->place].first);
    row.bind(4, names[parent->place].second);
    row.bind(5, parent->covariance.data(), static_cast<int>(sizeof parent->covariance));
    row.exec();
    row.reset();
  }
}

template <class Local>
void read_parents(SQLite::Database& database, std::vector<Local>& all) {
  std::map<RowName, std::size_t> places;
  for (const RowName& name : names_of(all)) places.emplace(name, places.size());
  MapCells rows(database, "place_parent",
                "SELECT session, number, parent_session, parent, covariance FROM place_parent "
                "ORDER BY session, number");
  while (rows.next()) {
    const auto place = places.find({rows.count(0), rows.whole(1)});
    const auto parent = places.find({rows.count(2), rows.whole(3)});
    if (place == places.end() || parent == places.end()) {
      throw Error("is no sound map: table 'place_parent' names a local map that is not there");
    }
    auto& out = parent_of(all[place->second]).emplace();
    out.place = parent->second;
    const std::string covariance = rows.bytes(4, sizeof out.covariance);
    if (covariance.size() != sizeof out.covariance) {
      throw Error("is no sound map: a row of table 'place_parent' has no covariance");
    }
    std::memcpy(out.covariance.data(), covariance.data(), covariance.size());
  }
}

}  // namespace

void write_parents(SQLite::Database& database, const MapRecord& record) {
  record.is_3d ? write_parents(database, record.local_clouds)
               : write_parents(database, record.local_maps);
}

void read_parents(SQLite::Database& database, MapRecord& out) {
  if (pragma(database, "user_version") < map_schema::kFirstWithParents) return;
  out.is_3d ? read_parents(database, out.local_clouds) : read_parents(database, out.local_maps);
}

}  // namespace hybrid
