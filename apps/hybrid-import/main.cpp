// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <string_view>
#include <utility>

#include "apps/command_line.h"
#include "apps/hybrid-import/formats.h"
#include "apps/program.h"
#include "apps/progress_line.h"
#include "mrpt_plugins/bridge/interrupt.h"

namespace {

constexpr const char* kAbout =
    "Converts data sets of others into MRPT rawlogs, with what is true written beside them.";

constexpr const char* kFooter =
    "\nWritten together: F.rawlog and, as far as known, F_ground_truth.txt,\n"
    "F_ground_truth_robot_path.txt or .xyz, F_ground_truth_associations.csv; those of an older\n"
    "F.rawlog go.\n"
    "\nExit code: 0 all well; 1 failure, nothing written; 129, 130, 143 stopped by SIGHUP, "
    "SIGINT,\n"
    "SIGTERM, nothing written.";

/// Words that are no format here, and what to use.
constexpr std::pair<const char*, const char*> kElsewhere[] = {
    {"yolo", "a form of csv: hybrid-import csv --detections FOLDER --odometry F.csv"},
    {"mot", "a form of csv: hybrid-import csv --detections det.txt --odometry F.csv"},
    {"coco", "a form of csv: hybrid-import csv --detections F.json --odometry F.csv"},
    {"tum", "a form of csv: hybrid-import csv --odometry F.txt --detections F.csv"},
    {"pcd", "a form of clouds: hybrid-import clouds FOLDER"},
    {"ply", "a form of clouds: hybrid-import clouds FOLDER"},
    {"mcap", "read by examples/ros2/mcap_to_csv.py, for hybrid-import csv"},
    {"rosbag", "read by examples/ros2/mcap_to_csv.py, for hybrid-import csv"},
    {"g2o", "read as it is: hybrid-pgo F.g2o"},
};

/// Whether the first word is one of these, which is told.
bool is_elsewhere(int argc, char** argv) {
  for (const auto& [word, answer] : kElsewhere) {
    if (argc < 2 || argv[1] != std::string_view(word)) continue;
    hybrid::complain("hybrid-import: '{}' is {}\nSee docs/importing.md.\n", word, answer);
    return true;
  }
  return false;
}

void print(const hybrid::ImportReport& report) {
  hybrid::say("{} steps over {:.1f} s, {} observations with {} detections, {} true landmarks\n",
              report.steps, report.duration, report.observations, report.detections,
              report.landmarks);
  for (const auto& [reason, count] : report.dropped) hybrid::say("{}: {}\n", reason, count);
  for (const std::string& note : report.notes) hybrid::say("{}\n", note);
  for (const std::string& file : report.files) hybrid::say("wrote {}\n", file);
}

}  // namespace

int main(int argc, char** argv) {
  return hybrid::run_program("hybrid-import", [&] {
    if (is_elsewhere(argc, argv)) return static_cast<int>(hybrid::kExitFailure);
    CLI::App app(kAbout, "hybrid-import");
    app.footer(kFooter);
    app.require_subcommand(1);
    std::string output;
    hybrid::Convert convert;
    for (const auto& add_format : hybrid::kFormats) {
      CLI::App* format = add_format(app, convert);
      format->add_option("-o,--output", output, "the rawlog to write")
          ->type_name("F.rawlog")
          ->required();
    }
    int exit_code = hybrid::kExitOk;
    if (!hybrid::parse_command_line(app, argc, argv, exit_code)) return exit_code;
    hybrid::note_interrupts();
    hybrid::ProgressLine line;
    hybrid::watch_steps([&line](const hybrid::ImportProgress& so_far) {
      if (!line.is_due()) return;
      line.show(fmt::format("{:3.0f} %  {} steps, {:.0f} s of the log  {}", 100 * so_far.share,
                            so_far.steps, so_far.seconds, line.time_left(so_far.share)));
    });
    const hybrid::ImportReport report = convert(output);
    hybrid::watch_steps({});
    line.clear();
    const int code = hybrid::settle(hybrid::kExitOk);
    print(report);
    return code;
  });
}
