// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "mrpt_plugins/experiment/plan.h"

namespace HYBRID_API hybrid {

/// How a trial ended, and its metrics.
struct TrialResult {
  /// ok, partial (the solver did not converge), failed, timeout or crashed: results of the method.
  /// unfinished: a fault of the machine (see MachineFault), and the trial is still to be run.
  std::string status = "ok";
  std::map<std::string, double> metrics;  ///< by name; absent where unknown
  std::string reliability;                ///< see reliability_text
  std::string message;                    ///< set unless the status is ok

  bool finished() const { return status != "unfinished"; }
  /// Whether a method has failed, crashed or taken too long.
  bool bad() const { return status == "failed" || status == "timeout" || status == "crashed"; }
};

/// results.csv: one row per finished trial. A row is appended and flushed when its trial ends, so
/// that an interruption loses only the running trials. A later row of a trial replaces an earlier
/// one. Only one program at a time may have it open.
class Ledger {
 public:
  /// Opens or creates `folder`/results.csv for rows with these metrics. Drops an incomplete last
  /// line. Throws Error if the file has other columns.
  Ledger(const std::filesystem::path& folder, std::vector<std::string> metrics);
  ~Ledger();
  Ledger(const Ledger&) = delete;
  Ledger& operator=(const Ledger&) = delete;

  bool empty() const { return results_.empty(); }
  bool contains(const Trial& trial) const { return results_.count(trial.key()) != 0; }
  /// Throws Error for a trial without a row.
  const TrialResult& at(const Trial& trial) const;
  /// Throws SystemError on failure; the file is then unchanged.
  void append(const Trial& trial, const TrialResult& result);

  const std::vector<std::string>& metrics() const { return metrics_; }
  /// The whole file with the rows of these trials first, in their order, then all others.
  std::string text(const std::vector<Trial>& trials) const;

 private:
  std::string row(const Trial& trial, const TrialResult& result) const;
  std::string header() const;
  /// Reads the rows of `text`; returns the number of bytes in whole rows.
  std::size_t read(const std::string& text);

  void append(const std::string& line);

  std::filesystem::path path_;
  std::vector<std::string> metrics_;
  std::map<std::string, TrialResult> results_;  // by key
  std::map<std::string, std::string> rows_;     // the same as text
  std::size_t bytes_ = 0;                       // in whole rows
  int file_ = -1;
};

}  // namespace hybrid
