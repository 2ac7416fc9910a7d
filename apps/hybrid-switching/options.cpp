// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-switching/options.h"

#include "apps/command_line.h"

namespace hybrid {
namespace {

constexpr const char* kAbout =
    "Finds the modes of a switching system: which motion a series follows at every instant, or\n"
    "which of a robot's ranges were measured in line of sight, and where the robot was.\n";

constexpr const char* kFooter =
    "\nA labelled series is a table, a row per instant. It is cut into folds; the modes of each "
    "are\n"
    "found with a model learnt from the other folds alone. Written to OUT: labels.csv,\n"
    "summary.json, modes.png, path.png.\n"
    "\nA log of ranges has rows 'range2' and 'odom2diff'. Written to OUT: trajectory.csv,\n"
    "ranges.csv, summary.json, modes.png, path.png.\n"
    "\nThe files replace the result that OUT holds; files of others stay.\n"
    "\nExit code: 0 all well; 1 failure, nothing written. A signal (Ctrl-C) ends it at once, with\n"
    "nothing written.\n"
    "\nExamples: hybrid-switching bee.txt --names left,right,waggle -o out\n"
    "          hybrid-switching uwb.txt --truth uwb_truth.txt -o out";

}  // namespace

std::optional<Options> parse_options(int argc, char** argv, int& exit_code) {
  Options options;
  CLI::App app(kAbout, "hybrid-switching");
  app.footer(kFooter);
  const CLI::Range column(1, 1000);
  app.add_option("input", options.input, "a labelled series or a log of ranges, told by its rows")
      ->type_name("FILE")
      ->required();
  app.add_option("--truth", options.truth, "true positions of a log of ranges, rows 'point2'")
      ->type_name("FILE");
  app.add_option("--label-column", options.label_column, "of the true mode, 0, 1, ...")
      ->type_name("N")
      ->check(column)
      ->capture_default_str();
  app.add_option("--angle-columns", options.angle_columns,
                 "angles [rad], which enter by their change from instant to instant")
      ->type_name("N,N")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(column)
      ->capture_default_str();
  app.add_option("--value-columns", options.value_columns, "values that enter as they are")
      ->type_name("N,N")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(column);
  app.add_option("--path-columns", options.path_columns, "x and y for path.png")
      ->type_name("N,N")
      ->delimiter(',')
      ->expected(2)
      ->check(column)
      ->capture_default_str();
  app.add_option("--names", options.names, "of the modes, for the pictures")
      ->type_name("A,B")
      ->delimiter(',')
      ->allow_extra_args(false);
  app.add_option("--order", options.order, "of the autoregressive motions")
      ->type_name("N")
      ->check(CLI::Range(0, 20))
      ->capture_default_str();
  app.add_option("--folds", options.folds, "contiguous parts of the series, each scored once")
      ->type_name("N")
      ->check(CLI::Range(2, 100))
      ->capture_default_str();
  app.add_flag("--without-labels", options.without_labels,
               "learn by expectation-maximisation; labels only give the modes their names");
  app.add_flag("!--no-pictures", options.pictures, "do not draw modes.png and path.png");
  add_output_folder(app, options.output);
  if (!parse_command_line(app, argc, argv, exit_code)) return std::nullopt;
  options.provenance = provenance_of(argc, argv);
  return options;
}

}  // namespace hybrid
