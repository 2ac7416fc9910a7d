// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-register/options.h"

#include "apps/command_line.h"

namespace hybrid {
namespace {

constexpr const char* kAbout =
    "Registers one point cloud to another: finds the rigid motion that takes SOURCE into TARGET,\n"
    "which points correspond, and which have no counterpart.\n";

constexpr const char* kFooter =
    "\nClouds: .xyz .txt .asc .csv (rows x y z), .ply (text or binary), .pcd, MRPT points\n"
    "maps and simple maps, and rawlogs: LOG.rawlog#N is what the scans of step N see.\n"
    "\nWritten to OUT: transform.txt (4x4, source into target), summary.json, overlay.png. They\n"
    "replace the result that OUT holds; files of others stay.\n"
    "\nExit code: 0 all well; 1 failure, nothing written; 2 the clouds leave a motion free (two\n"
    "planes slide, two lines turn): the transform was written, and summary.json says which. A\n"
    "signal (Ctrl-C) ends it at once, with nothing written.\n"
    "\nExample: hybrid-register scan2.ply scan1.ply -o out";

}  // namespace

std::optional<Options> parse_options(int argc, char** argv, int& exit_code) {
  Options options;
  CLI::App app(kAbout, "hybrid-register");
  app.footer(kFooter);
  app.add_option("source", options.source, "the cloud that moves")->type_name("SOURCE")->required();
  app.add_option("target", options.target, "the cloud that stays")->type_name("TARGET")->required();
  app.add_option("--metric", options.metric,
                 "surface: distance to the surface of the target (point to plane), or to its curve "
                 "where it is a plane scan; point: distance to the point")
      ->type_name("METRIC")
      ->check(CLI::IsMember({"surface", "point"}))
      ->capture_default_str();
  app.add_option("--start", options.start,
                 "file with a 4x4 matrix to start from, as transform.txt; default: the identity")
      ->type_name("FILE");
  app.add_flag("!--no-search", options.search,
               "keep to the start also where less than 80 % of the source finds a counterpart");
  app.add_option("--threads", options.threads, "0: one per core; the result does not depend on it")
      ->type_name("N")
      ->check(CLI::Range(0, 256))
      ->capture_default_str();
  app.add_option("--unit", options.unit, "unit of length for picture and messages, e.g. m")
      ->type_name("UNIT");
  add_output_folder(app, options.output);
  if (!parse_command_line(app, argc, argv, exit_code)) return std::nullopt;
  options.provenance = provenance_of(argc, argv);
  return options;
}

}  // namespace hybrid
