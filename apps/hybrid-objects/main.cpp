// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <set>

#include "apps/command_line.h"
#include "apps/hybrid-objects/report.h"
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
    "\nWritten to OUT: summary.json; to OUT/SEQUENCE: objects.csv, trajectory.tum, objects.png.\n"
    "\nExit code: 0 all well; 1 failure.\n"
    "\nExample: hybrid-objects ycbv/0001 ycbv/0014 -o out";

std::string name_of(const std::filesystem::path& folder) {
  const std::filesystem::path path = std::filesystem::absolute(folder).lexically_normal();
  return (path.has_filename() ? path : path.parent_path()).filename().string();
}

int run(const std::vector<std::string>& folders, const std::string& output) {
  std::vector<hybrid::ObjectReport> reports;
  std::set<std::string> names;
  for (const std::string& folder : folders) {
    if (!names.insert(name_of(folder)).second) {
      throw hybrid::Error(folder + ": another sequence has the same name; run them one by one");
    }
    reports.push_back(hybrid::solve_sequence(name_of(folder), folder));
  }
  hybrid::write_reports(reports, output);
  fmt::print("{}-> {}\n", hybrid::comparison_table(reports), output);
  return hybrid::kExitOk;
}

}  // namespace

int main(int argc, char** argv) try {
  std::vector<std::string> folders;
  std::string output = "hybrid-objects-out";
  CLI::App app(kAbout, "hybrid-objects");
  app.footer(kFooter);
  app.add_option("sequences", folders, "folders of detections")->type_name("SEQUENCE")->required();
  hybrid::add_output_folder(app, output);
  int exit_code = hybrid::kExitOk;
  return hybrid::parse_command_line(app, argc, argv, exit_code) ? run(folders, output) : exit_code;
} catch (const std::exception& e) {
  fmt::print(stderr, "hybrid-objects: {}\n", e.what());
  return hybrid::kExitFailure;
}
