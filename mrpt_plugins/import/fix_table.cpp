// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/detail/fix_table.h"

#include <fmt/format.h>

#include <cmath>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/import/detail/table_odometry.h"

namespace hybrid {
namespace {

const std::vector<std::string> kFixColumns{"time", "latitude", "longitude", "altitude", "x",
                                           "y",    "z",        "sigma",     "quality"};

/// Those of all tables, and those of places on Earth.
ColumnAliases fix_aliases() {
  ColumnAliases aliases = kColumnAliases;
  for (const char* name : {"lat", "lat_deg", "latitude_deg"}) aliases[name] = "latitude";
  for (const char* name : {"lon", "long", "lng", "lon_deg", "longitude_deg"}) {
    aliases[name] = "longitude";
  }
  aliases["alt"] = "altitude";
  return aliases;
}

/// The place that --datum gives.
GeodeticPoint datum_of(const std::vector<double>& datum) {
  if (datum.size() != 3) throw Error("--datum has three numbers: latitude longitude altitude");
  if (!(std::abs(datum[0]) <= 90) || !(std::abs(datum[1]) <= 360) || !std::isfinite(datum[2])) {
    throw Error(fmt::format("--datum {} {} {} is no latitude, longitude [deg] and altitude [m]",
                            datum[0], datum[1], datum[2]));
  }
  return {datum[0], datum[1], datum[2]};
}

}  // namespace

FixTable::FixTable(const FixTableOptions& options)
    : options_(options), table_(options.table, kFixColumns, fix_aliases()), label_("GPS") {
  if (options.antenna.size() != 3) throw Error("--antenna has three numbers: x y z");
  check_columns();
  if (!table_.has("latitude")) {
    frame_.emplace(options.datum.empty() ? GeodeticPoint() : datum_of(options.datum));
    if (options.datum.empty()) label_ += "_local";
  }
  advance();
  first_ = last_ = next_ ? next_->time : 0;
}

void FixTable::check_columns() const {
  const bool is_local = table_.has("x") || table_.has("y") || table_.has("z");
  const bool is_geodetic =
      table_.has("latitude") || table_.has("longitude") || table_.has("altitude");
  if (is_local && is_geodetic) table_.refuse("columns x, y beside lat, lon: one or the other");
  if (is_local) {
    table_.require({"time", "x", "y"});
  } else {
    table_.require({"time", "latitude", "longitude"});
    if (!options_.datum.empty()) {
      table_.refuse("--datum is for tables with x and y; this one has places on Earth");
    }
  }
}

std::vector<mrpt::obs::CObservation::Ptr> FixTable::take(double time) {
  const auto& a = options_.antenna;
  std::vector<mrpt::obs::CObservation::Ptr> fixes;
  while (next_ && next_->time == time) {
    fixes.push_back(satellite_fix(*next_, label_, {a[0], a[1], a[2], 0, 0, 0}));
    last_ = time;
    advance();
  }
  return fixes;
}

void FixTable::advance() {
  const std::optional<SatelliteFix> before = next_;
  next_.reset();
  if (!table_.next()) return;
  const double time = table_.time();
  if (before && time < before->time) {
    table_.fail("time", "time goes backwards: sort the rows by it");
  }
  next_ = SatelliteFix{time, place(), quality(), table_.sigma("sigma")};
}

GeodeticPoint FixTable::place() {
  if (!frame_) return stated_place();
  Eigen::Vector3d local(table_.number("x"), table_.number("y"),
                        table_.has("z") ? table_.number("z") : 0);
  if (options_.datum.empty()) {
    if (!subtracted_) subtracted_ = local;
    local -= *subtracted_;
  }
  constexpr double kFarthest = 1e6;  // [m]
  if (local.norm() > kFarthest) {
    table_.fail("x",
                fmt::format("a place {:.0f} km from {}", local.norm() / 1000,
                            options_.datum.empty() ? "that of the first row"
                                                   : "--datum, to which x, y, z are relative"));
  }
  return frame_->to_geodetic(local);
}

GeodeticPoint FixTable::stated_place() const {
  const GeodeticPoint place{table_.number("latitude"), table_.number("longitude"),
                            table_.has("altitude") ? table_.number("altitude") : 0};
  if (std::abs(place.latitude) > 90) {
    table_.fail("latitude", fmt::format("latitude {} is beyond 90 degrees", place.latitude));
  }
  if (std::abs(place.longitude) > 360) {
    table_.fail("longitude", fmt::format("longitude {} is beyond 360 degrees", place.longitude));
  }
  return place;
}

std::uint8_t FixTable::quality() const {
  constexpr std::int64_t kUsual = 1, kMost = 8;
  const std::int64_t quality = table_.id("quality").value_or(kUsual);
  if (quality > kMost) {
    table_.fail("quality", fmt::format("quality {} is none of GGA, 0 to {}", quality, kMost));
  }
  return static_cast<std::uint8_t>(quality);
}

void FixTable::finish(LogWriter& log) const {
  for (const std::string& name : table_.ignored()) {
    log.note(fmt::format("{}: column {} is left aside", table_.path(), name.empty() ? "''" : name));
  }
  table_.note_blanks(log);
  log.note_end(options_.table);
  if (!subtracted_) return;
  const Eigen::Vector3d& p = *subtracted_;
  log.note(fmt::format(
      "{}: no --datum: places are relative to the first row, {:.10g} {:.10g} {:.10g} m, "
      "which is put to latitude and longitude 0; sensor label {}",
      table_.path(), p.x(), p.y(), p.z(), label_));
}

}  // namespace hybrid
