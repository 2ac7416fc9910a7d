// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// The commands that change no map.

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "apps/exit_code.h"
#include "apps/hybrid-map/commands.h"
#include "apps/hybrid-map/map_scene.h"
#include "apps/program.h"
#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/output_directory.h"
#include "mrpt_plugins/map_file/export_map.h"
#include "mrpt_plugins/output/cloud_writer.h"
#include "mrpt_plugins/output/landmark_writer.h"
#include "mrpt_plugins/output/map_image.h"
#include "mrpt_plugins/output/scan_map.h"
#include "mrpt_plugins/output/trajectory_writer.h"

namespace hybrid {
namespace {

using Json = nlohmann::ordered_json;

std::size_t existing(const MapRecord& map) {
  return static_cast<std::size_t>(
      std::count_if(map.landmarks.begin(), map.landmarks.end(), exists));
}

Json describe(const MapRecord& map) {
  const std::vector<MapWay> ways = ways_of(map);
  Json out = {{"dimension", map.dim()},
              {"classes", map.class_names},
              {"landmarks", existing(map)},
              {"vanished", map.landmarks.size() - existing(map)},
              {"local_maps", map.local_maps.size()},
              {"local_clouds", map.local_clouds.size()},
              {"prior_loss_nat", map.prior.loss},
              {"sessions", Json::array()}};
  for (const MapSession& s : map.sessions) {
    Json inputs = Json::array();
    for (const auto& [path, sha256] : s.inputs) {
      inputs.push_back({{"path", path}, {"sha256", sha256}});
    }
    Json robots = Json::array();
    for (const MapWay& way : ways) {
      if (way.session != s.id || way.robot.empty()) continue;
      robots.push_back({{"name", way.robot}, {"keyframes", way.poses.size()}});
    }
    out["sessions"].push_back({{"session", s.id},
                               {"mode", s.mode},
                               {"complete", s.complete},
                               {"keyframes", s.keyframes.size()},
                               {"robots", std::move(robots)},
                               {"version", s.version},
                               {"command", s.command},
                               {"inputs", std::move(inputs)}});
  }
  return out;
}

/// "", or which robots a session was of, with their keyframes.
std::string robots_text(const MapRecord& map, const MapSession& session) {
  std::string text;
  for (const MapWay& way : ways_of(map)) {
    if (way.session != session.id || way.robot.empty()) continue;
    text += fmt::format("{}{} {}", text.empty() ? " (" : ", ", way.robot, way.poses.size());
  }
  return text.empty() ? "" : text + ")";
}

}  // namespace

std::string places_text(const MapRecord& map) {
  std::string out;
  if (!map.local_maps.empty()) {
    out += fmt::format(", {} local maps of laser scans", map.local_maps.size());
  }
  if (!map.local_clouds.empty()) {
    out += fmt::format(", {} local maps of clouds", map.local_clouds.size());
  }
  return out;
}

int info(const Options& options) {
  const MapRecord map = read_map(options.maps[0]);
  if (options.json) {
    say("{}\n", describe(map).dump(1));
    return kExitOk;
  }
  say("{}: a map {}, {} landmarks", options.maps[0], map.is_3d ? "in space" : "in the plane",
      existing(map));
  if (existing(map) < map.landmarks.size()) {
    say(" and {} that vanished", map.landmarks.size() - existing(map));
  }
  say("{}, {} classes\n", places_text(map), map.class_names.size());
  for (const MapSession& s : map.sessions) {
    say("session {}: {}, {} keyframes{}{}, {}\n", s.id, s.mode, s.keyframes.size(),
        robots_text(map, s), s.complete ? "" : ", interrupted",
        s.inputs.empty() ? "-" : s.inputs.front().first);
  }
  return kExitOk;
}

int check(const Options& options) {
  read_map(options.maps[0]);  // throws where anything is wrong
  say("{}: all well{}\n", options.maps[0],
      has_checksum(options.maps[0]) ? "" : ", but of a format without checksum");
  return kExitOk;
}

int export_map(const Options& options) {
  const MapRecord map = read_map(options.maps[0]);
  OutputDirectory out(options.output);
  const MapResult result =
      result_of(map, std::filesystem::path(options.maps[0]).filename().string());
  out.write("landmarks.csv", landmarks_csv(result));
  out.write("landmarks.json", landmarks_json(result));
  out.write("landmarks.pcd", pcd_text(map));
  for (const MapWay& way : ways_of(map)) {
    const std::string whose = way.robot.empty() ? "" : "_" + way.robot;
    out.write(fmt::format("trajectory_{}{}.tum", way.session, whose), tum_text(way.poses));
  }
  const std::optional<MapOrigin> origin =
      options.origin.empty() ? map.origin : stated_origin(options.origin);
  if (origin) out.write("map.geojson", geojson_text(map, *origin));
  if (options.mcap) out.write("map.mcap", mcap_of(map));
  if (result.grid) {
    out.write("map.pgm", grid_pgm(*result.grid));
    out.write("map.yaml", grid_yaml(*result.grid, "map.pgm"));
  }
  if (result.cloud) {
    out.write("cloud.ply", cloud_ply(*result.cloud));
    out.write("cloud.pcd", cloud_pcd(*result.cloud));
  }
  if (options.pictures) out.write("map.png", png(map_image(result)));
  Provenance provenance = options.provenance;
  provenance.add_input(options.maps[0]);
  Json summary = summary_start("ok", "", provenance);
  summary.update(describe(map));
  warn_of(out.publish(std::move(summary)));
  say("{} landmarks, {} sessions -> {}\n", existing(map), map.sessions.size(),
      out.folder().string());
  return kExitOk;
}

}  // namespace hybrid
