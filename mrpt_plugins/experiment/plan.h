// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "mrpt_plugins/bridge/ini_file.h"
#include "mrpt_plugins/bridge/method_options.h"
#include "mrpt_plugins/bridge/provenance.h"

namespace HYBRID_API hybrid {

/// A pose graph of an experiment, or a family of graphs whose file names differ in one word.
struct GraphPlan {
  std::string name;
  std::string file;
  std::vector<std::string> variants;  ///< values of {variant}; one empty word if there are none
  std::string variant_label;          ///< name of the variants in plots
  std::string start = "file";         ///< of file, odometry, chordal, tree: as hybrid-pgo --start
  bool repair_information = false;
  std::string truth, truth_times;  ///< empty: the best known optimum of the true closures
  std::string labels;  ///< file of pairs `i j`, the true closures; empty: by the tolerances below
  /// Largest difference of a true closure from the truth [m, rad]; 0: all closures are true.
  double label_distance = 0, label_angle = 0;
};

/// A replay of an experiment.
struct ReplayPlan {
  struct Log {
    std::string name;  ///< of the file, without its extension
    std::string path;
  };

  std::string name;
  std::string config;     ///< INI of hybrid-replay
  std::string simulate;   ///< INI of hybrid-simulate, run first with every seed; empty: none
  std::vector<Log> logs;  ///< one trial each; one without a name: the log of the INI
  bool maps = false;      ///< whether every trial writes a map file
};

/// Settings of a variant of a replay, which takes the place of a method.
struct ReplayVariant {
  std::string name;
  std::vector<std::string> settings;  ///< section.key=value
};

/// The text with every {variant} replaced.
std::string with_variant(std::string text, const std::string& variant);

/// One run of an experiment, identified by its key.
struct Trial {
  std::size_t source = 0;  ///< index of the graph or replay
  std::string graph, variant, method;
  double outlier_rate = 0;
  std::uint64_t seed = 0;

  std::string key() const;
};

/// An experiment as an INI file describes it.
struct ExperimentPlan {
  bool replay = false;  ///< else trials on pose graphs
  std::string title;
  std::vector<GraphPlan> graphs;
  std::vector<ReplayPlan> replays;
  std::vector<std::string> methods;
  std::vector<ReplayVariant> replay_variants;  ///< one per method, for replays
  std::vector<std::string> fields;             ///< of summary.json, for replays
  MethodOptions method_options;
  std::vector<double> outlier_rates;
  int trials = 1;
  std::uint64_t first_seed = 1;
  double time_limit = 0;  ///< seconds
  double success_ate = 0.1;
  int jobs = 0;
  double rank_silence = 0;  ///< seconds after which a rank that says nothing is given up
  std::vector<Provenance::Input> inputs;  ///< files read
  /// Settings that affect the result of a trial without being in its key, by section.key, and
  /// hashes of the files read, by graph/file.
  std::map<std::string, std::string> fingerprint;
};

/// Declares and reads all sections. Throws Error naming the key for anything unknown or wrong, and
/// for missing files.
ExperimentPlan read_plan(IniFile& ini);

/// All trials, by graph, variant, rate, seed and method.
std::vector<Trial> trials_of(const ExperimentPlan& plan);

}  // namespace hybrid
