// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-map/commands.h"

#include "apps/command_line.h"

namespace hybrid {
namespace {

constexpr const char* kAbout =
    "Looks into map files that 'hybrid-replay --map F.hmap' makes: what they hold, whether they\n"
    "are whole, their content in other formats; joins maps, and removes sessions.\n";

constexpr const char* kFooter =
    "\nA map file is a SQLite database; its tables are described in docs/map_format.md.\n"
    "\nExit code: 0 all well; 1 failure, nothing written.\n"
    "\nExample: hybrid-map export park.hmap -o park";

}  // namespace

std::optional<Options> parse_options(int argc, char** argv, int& exit_code) {
  Options o;
  o.maps.resize(1);
  CLI::App app(kAbout, "hybrid-map");
  app.footer(kFooter);
  app.require_subcommand(1);
  const auto command = [&](const char* name, const char* about) {
    CLI::App* sub = app.add_subcommand(name, about);
    sub->callback([&o, name] { o.command = name; });
    return sub;
  };
  const auto one_map = [&](CLI::App* sub) {
    sub->add_option("map", o.maps[0], "the map file")->type_name("F.hmap")->required();
    return sub;
  };
  one_map(command("info", "tells what a map holds"))->add_flag("--json", o.json, "as JSON");
  one_map(command("check", "reads all of a map and tells what is wrong with it"));
  CLI::App* to = one_map(
      command("export",
              "writes landmarks.csv, landmarks.json, landmarks.pcd, trajectory_N.tum for each "
              "session (trajectory_N_NAME.tum for each of several robots), map.geojson where the "
              "origin is known, map.pgm and map.yaml where there are laser scans, map.png, "
              "summary.json"));
  to->add_option("-o,--output", o.output, "folder, created if absent")
      ->type_name("OUT")
      ->required();
  to->add_option("--origin", o.origin,
                 "latitude and longitude of the origin of the map, and the direction of its x axis "
                 "counter-clockwise from east [deg]")
      ->expected(3);
  to->add_flag("--mcap", o.mcap, "write map.mcap too, landmarks and paths for Foxglove");
  to->add_flag("!--no-pictures", o.pictures, "do not draw map.png");
  CLI::App* join =
      command("join", "makes one map of several by the landmarks or laser scans that they share");
  join->add_option("maps", o.maps, "the map files; the frame is that of the first")
      ->type_name("A.hmap B.hmap ...")
      ->required()
      ->expected(2, 1000);
  join->add_option("-o,--output", o.output, "the new map file")
      ->type_name("C.hmap")
      ->required()
      ->check(&fault_of_file_name);
  join->add_option("--odds", o.odds, "evidence that a common place needs")
      ->check(CLI::Range(1.0, 1e300))
      ->capture_default_str();
  CLI::App* prune = one_map(command("prune", "removes sessions or landmarks from a map"));
  prune->add_option("--session", o.sessions,
                    "session whose keyframes go; of one that is complete the landmarks stay");
  prune->add_option("--robot", o.robots, "robot whose keyframes go from all sessions");
  prune->add_flag("--vanished", o.vanished, "landmarks that are more likely gone than there");
  if (!parse_command_line(app, argc, argv, exit_code)) return std::nullopt;
  o.provenance = provenance_of(argc, argv);
  return o;
}

}  // namespace hybrid
