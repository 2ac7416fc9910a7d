// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "libhybrid/io/file_group.h"
#include "libhybrid/io/file_writer.h"

namespace HYBRID_API hybrid {

/// A folder that shows one whole result: that of the run before, or, once it is published, the new
/// one. Files are written aside until then. summary.json lists those of a result with their hashes;
/// what it does not list is somebody else's and stays.
///
/// One process writes into a folder at a time. Nothing is left of one that died. All functions
/// throw Error that names the path and the reason; nothing has changed then.
class OutputDirectory {
 public:
  /// Creates the folder and its parents where absent (and removes them if nothing is published).
  /// Files called `own` may be replaced though no summary lists them, and are not listed either:
  /// they outlast results.
  explicit OutputDirectory(std::filesystem::path folder, std::vector<std::string> own = {});

  const std::filesystem::path& folder() const { return folder_; }

  /// Writes `content` (text or bytes) as the file `name`, which may stand in a folder below.
  void write(const std::string& name, std::string_view content) const;

  /// The file `name`, to be written bit by bit and closed before the result is published.
  std::unique_ptr<FileWriter> open(const std::string& name) const;

  /// For writers that want a path: `save` gets one with the extension of `name`, and throws if it
  /// fails.
  void save(const std::string& name, const std::function<void(const std::string&)>& save) const;

  /// Shows the new result, with `summary` and the list of files as summary.json. Returns what the
  /// user should know: files of others that had the names of new ones have got another name. Call
  /// it once.
  std::vector<std::string> publish(const nlohmann::ordered_json& summary);

 private:
  std::vector<std::string> former_files() const;
  bool is_own(const std::string& name) const;
  bool holds_only(const std::vector<std::string>& former, const std::string& below = "") const;

  std::filesystem::path folder_;
  std::vector<std::string> own_;
  FileGroup group_;
};

}  // namespace hybrid
