// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-experiment/options.h"

#include <fmt/format.h>

#include "apps/command_line.h"
#include "apps/method_list.h"

namespace hybrid {
namespace {

constexpr const char* kAbout =
    "Runs an experiment: many trials over graphs, shares of false loop closures, methods and "
    "seeds,\n"
    "or over replays of logs, several at a time, and draws what came out.\n";

std::string footer() {
  std::string text = "\nMethods for pose graphs:\n" + method_list();
  text +=
      "\nWritten to OUT: results.csv (a row per trial, appended as it ends), summary.csv (medians\n"
      "and quartiles), summary.txt (the table printed at the end), summary.json, a PNG per graph,\n"
      "reliability_*.png, experiment.ini (the settings); for replays also trials/ and, if asked "
      "for,\n"
      "maps/; with --report report.html.\n"
      "\nIt may be interrupted at any time: run again with the same OUT, it goes on where it was, "
      "and\n"
      "trials that have ended are not run again. More trials, rates, methods or graphs may be "
      "asked\n"
      "for meanwhile; with other settings or changed files it stops and says which. Trials that "
      "the\n"
      "machine kept from ending (disk or memory full, killed, too busy) are \"unfinished\" and "
      "run\n"
      "again the next time.\n"
      "\nOn many machines: mpirun -np 9 hybrid-experiment -c INI -o OUT runs eight trials at a "
      "time, and\n"
      "one process hands them out; likewise srun under Slurm. See docs/cluster.md.\n"
      "\nExit code: 0 all well; 1 failure, nothing written but trials that had ended; 2 some "
      "trials\n"
      "failed or are unfinished: results.csv says which and why; 129, 130, 143 stopped by SIGHUP,\n"
      "SIGINT (Ctrl-C), SIGTERM: the trials that were running count as not run.\n"
      "\nExample: hybrid-experiment -c config/experiments/fig2.ini -o out";
  return text;
}

}  // namespace

std::optional<Options> parse_options(int argc, char** argv, int& exit_code) {
  Options options;
  CLI::App app(kAbout, "hybrid-experiment");
  app.footer(footer());
  app.add_option("-c,--config", options.config, "INI file with all settings; see --print-config")
      ->type_name("INI");
  add_settings(app, options.settings);
  add_output_folder(app, options.output);
  app.add_option("--data-dir", options.data_dir,
                 "folder of the graphs, instead of [experiment] "
                 "data_dir and $HYBRID_DATA_DIR")
      ->type_name("DIR");
  app.add_option("-j,--jobs", options.jobs, "trials at a time, instead of [experiment] jobs")
      ->type_name("N")
      ->check(CLI::Range(1, 1024));
  app.add_flag("--retry", options.retry,
               "run trials again that failed, crashed or took too long, as with a mended program");
  app.add_flag("--summary", options.summary_only,
               "run nothing: tables and plots of the trials that OUT has");
  app.add_flag("--report", options.report,
               "write report.html, a page with all trials, to sort and filter in a browser");
  app.add_flag("--print-config", options.print_config,
               "print every section and key with its meaning, default and the value in effect");
  app.callback([&] {
    if (options.config.empty() && !options.print_config) {
      throw CLI::RequiredError("-c (try -c config/experiments/fig2.ini, or --help)");
    }
  });
  if (!parse_command_line(app, argc, argv, exit_code)) return std::nullopt;
  options.provenance = provenance_of(argc, argv);
  return options;
}

}  // namespace hybrid
