// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <set>

#include "apps/command_line.h"
#include "apps/hybrid-objects/report.h"
#include "apps/program.h"
#include "libhybrid/core/error.h"

namespace {

constexpr const char* kAbout =
    "Maps objects that a camera detects, with an inlier/outlier variable for each detection, and\n"
    "compares with the robust kernels of Huber and Cauchy on the same graph from the same start.\n";

constexpr const char* kFooter =
    "\nA SEQUENCE is a folder with odom.txt, det_NAME.txt per object and, for errors, cam_gt.txt "
    "and\n"
    "objgt_NAME.txt; rows `t x y z qx qy qz qw`, one per frame; a quaternion of zeros where the\n"
    "object was not detected.\n"
    "\nWritten to OUT: summary.json; to OUT/SEQUENCE: objects.csv, trajectory.tum, objects.png. "
    "They\n"
    "replace the result that OUT holds; files of others stay.\n"
    "\nExit code: 0 all well; 1 failure, nothing written; 2 the solver did not converge: its "
    "estimate\n"
    "was written, and summary.json has status \"partial\". A signal (Ctrl-C) ends it at once, "
    "with\n"
    "nothing written.\n"
    "\nExample: hybrid-objects ycbv/0001 ycbv/0014 -o out";

std::string name_of(const std::filesystem::path& folder) {
  const std::filesystem::path path = std::filesystem::absolute(folder).lexically_normal();
  return (path.has_filename() ? path : path.parent_path()).filename().string();
}

int run(const std::vector<std::string>& folders, bool measured, const std::string& output,
        hybrid::Provenance provenance) {
  std::vector<hybrid::ObjectReport> reports;
  std::set<std::string> names;
  for (const std::string& folder : folders) {
    if (!names.insert(name_of(folder)).second) {
      throw hybrid::Error(folder + ": another sequence has the same name; run them one by one");
    }
    reports.push_back(hybrid::solve_sequence(name_of(folder), folder, measured));
    hybrid::add_sequence(folder, provenance);
  }
  hybrid::warn_of_inputs(provenance);
  const int code = hybrid::write_reports(reports, output, provenance);
  hybrid::say("{}{}-> {}\n", hybrid::noise_lines(reports), hybrid::comparison_table(reports),
              output);
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  return hybrid::run_program("hybrid-objects", [&] {
    std::vector<std::string> folders;
    std::string output = "hybrid-objects-out";
    CLI::App app(kAbout, "hybrid-objects");
    app.footer(kFooter);
    app.add_option("sequences", folders, "folders of detections")
        ->type_name("SEQUENCE")
        ->required();
    std::string noise = "measured";
    app.add_option(
           "--noise", noise,
           "measured: from pairs of frames, where they tell it; stated: 0.1 mm and 0.1 mrad "
           "a frame, 1 cm and 0.03 rad a detection")
        ->check(CLI::IsMember({"measured", "stated"}))
        ->capture_default_str();
    hybrid::add_output_folder(app, output);
    int exit_code = hybrid::kExitOk;
    if (!hybrid::parse_command_line(app, argc, argv, exit_code)) return exit_code;
    return run(folders, noise == "measured", output, hybrid::provenance_of(argc, argv));
  });
}
