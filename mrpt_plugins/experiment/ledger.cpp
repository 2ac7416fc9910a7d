// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/experiment/ledger.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>

#include "libhybrid/core/error.h"
#include "libhybrid/io/file_writer.h"
#include "libhybrid/io/folders.h"
#include "libhybrid/io/parse_number.h"
#include "libhybrid/io/regular_file.h"

namespace hybrid {
namespace {

const std::vector<std::string> kBefore = {"trial",        "graph", "variant", "method",
                                          "outlier_rate", "seed",  "status"};
const std::vector<std::string> kStatuses = {"ok",      "partial", "failed",
                                            "timeout", "crashed", "unfinished"};
const std::vector<std::string> kAfter = {"reliability", "message"};

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells(1);
  for (char c : line) {
    if (c == ',') {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  return cells;
}

/// The text as a CSV cell without quotes.
std::string plain(std::string text) {
  std::replace(text.begin(), text.end(), ',', ';');
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r' || c == '"'; }, ' ');
  return text;
}

}  // namespace

Ledger::Ledger(const std::filesystem::path& folder, std::vector<std::string> metrics)
    : path_(folder / "results.csv"), metrics_(std::move(metrics)) {
  const std::string text = name_exists(path_) ? read_file(path_.string()) : std::string();
  try {
    bytes_ = read(text);
  } catch (const Error& e) {
    throw Error(path_.string() + ": " + e.what());
  }
  file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (file_ < 0) throw SystemError(path_.string(), errno);
  try {
    if (::ftruncate(file_, static_cast<off_t>(bytes_)) != 0)
      throw SystemError(path_.string(), errno);
    if (bytes_ == 0) append(header());
    sync_to_disk(folder);
  } catch (...) {
    ::close(file_);
    throw;
  }
}

Ledger::~Ledger() {
  ::close(file_);
}

std::size_t Ledger::read(const std::string& text) {
  std::size_t whole = 0;
  for (std::size_t number = 1; whole < text.size(); ++number) {
    const std::size_t end = text.find('\n', whole);
    if (end == std::string::npos) return whole;  // incomplete last line
    const std::string line = text.substr(whole, end - whole);
    if (number == 1 && line + "\n" != header()) {
      throw Error("has other columns than this experiment; use another output folder");
    }
    const std::vector<std::string> cells = split(line);
    if (cells.size() != kBefore.size() + metrics_.size() + kAfter.size()) {
      throw Error(
          fmt::format("line {} has {} cells instead of {}; remove it to run its trial again",
                      number, cells.size(), kBefore.size() + metrics_.size() + kAfter.size()));
    }
    whole = end + 1;
    if (number == 1) continue;
    TrialResult result;
    result.status = cells[kBefore.size() - 1];
    if (std::find(kStatuses.begin(), kStatuses.end(), result.status) == kStatuses.end()) {
      throw Error(fmt::format("line {}: '{}' is no status ({}); remove it to run its trial again",
                              number, result.status, fmt::join(kStatuses, ", ")));
    }
    for (std::size_t m = 0; m < metrics_.size(); ++m) {
      const std::string& cell = cells[kBefore.size() + m];
      double value = 0;
      if (cell.empty()) continue;
      if (!parse_number(cell, value)) {
        throw Error(fmt::format("line {}: '{}' is not a number", number, cell));
      }
      result.metrics[metrics_[m]] = value;
    }
    result.reliability = cells[cells.size() - 2];
    result.message = cells.back();
    results_[cells[0]] = std::move(result);
    rows_[cells[0]] = line + "\n";
  }
  return whole;
}

std::string Ledger::header() const {
  return fmt::format("{},{},{}\n", fmt::join(kBefore, ","), fmt::join(metrics_, ","),
                     fmt::join(kAfter, ","));
}

std::string Ledger::row(const Trial& trial, const TrialResult& result) const {
  std::string text = fmt::format("{},{},{},{},{},{},{}", trial.key(), trial.graph, trial.variant,
                                 trial.method, trial.outlier_rate, trial.seed, result.status);
  for (const std::string& name : metrics_) {
    const auto it = result.metrics.find(name);
    text += ',';
    if (it != result.metrics.end() && std::isfinite(it->second)) {
      text += fmt::format("{}", it->second);
    }
  }
  return text + fmt::format(",{},{}\n", plain(result.reliability), plain(result.message));
}

const TrialResult& Ledger::at(const Trial& trial) const {
  const auto it = results_.find(trial.key());
  if (it == results_.end()) throw Error("trial " + trial.key() + " has not been run");
  return it->second;
}

void Ledger::append(const std::string& line) {
  int error = ::lseek(file_, static_cast<off_t>(bytes_), SEEK_SET) < 0 ? errno : 0;
  if (error == 0) error = write_all(file_, line);
  if (error == 0 && ::fdatasync(file_) != 0) error = errno;
  if (error != 0) {
    // If truncation fails, the next program to open the file drops the incomplete row.
    [[maybe_unused]] const int ignored = ::ftruncate(file_, static_cast<off_t>(bytes_));
    throw SystemError(path_.string(), error);
  }
  bytes_ += line.size();
}

void Ledger::append(const Trial& trial, const TrialResult& result) {
  const std::string line = row(trial, result);
  append(line);
  results_[trial.key()] = result;
  rows_[trial.key()] = line;
}

std::string Ledger::text(const std::vector<Trial>& trials) const {
  std::string text = header();
  std::map<std::string, std::string> others = rows_;
  for (const Trial& trial : trials) {
    const auto it = others.find(trial.key());
    if (it == others.end()) continue;
    text += it->second;
    others.erase(it);
  }
  for (const auto& [key, row] : others) text += row;
  return text;
}

}  // namespace hybrid
