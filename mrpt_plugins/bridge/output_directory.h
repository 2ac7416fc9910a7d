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

/// A folder that holds one whole result: the former one until publish(), the new one afterwards.
/// New files are staged until then. summary.json lists the files of a result with their hashes;
/// files that it does not list belong to others and stay.
///
/// Only one process at a time may write into a folder. What a process that died left there is
/// removed, or completed if it was publishing. All functions throw Error that names the path and
/// the reason, and leave the folder unchanged then.
class OutputDirectory {
 public:
  /// Creates the folder and its parents where absent (and removes them if nothing is published).
  /// Files named in `own` may be replaced although no summary lists them; new summaries do not list
  /// them either, so that they outlast results.
  explicit OutputDirectory(const std::filesystem::path& folder, std::vector<std::string> own = {});

  const std::filesystem::path& folder() const { return folder_; }

  /// Stages `content` (text or bytes) as the file `name`, which may include a subfolder.
  void write(const std::string& name, std::string_view content) const;

  /// Stages the file `name`, to be written in parts and closed before publish().
  std::unique_ptr<FileWriter> open(const std::string& name) const;

  /// For writers that take a path: `save` gets a path with the extension of `name`, and throws on
  /// failure.
  void save(const std::string& name, const std::function<void(const std::string&)>& save) const;

  /// Publishes the new result, with `summary` and the list of files as summary.json. Returns
  /// messages for the user: files of others that had the name of a new file were renamed. Call it
  /// once. Hand the summary over by std::move: its memory is freed before the files are exchanged,
  /// since freeing JSON allocates, and nothing may fail behind the exchange.
  std::vector<std::string> publish(nlohmann::ordered_json summary);

 private:
  std::vector<std::string> former_files() const;
  bool is_own(const std::string& name) const;
  bool holds_only(const std::vector<std::string>& former, const std::string& below = "") const;

  std::filesystem::path folder_;
  std::vector<std::string> own_;
  FileGroup group_;
};

/// Sets a key of the summary.json that a folder holds; the other files stay. Throws Error.
void amend_summary(const std::filesystem::path& folder, const std::string& key,
                   nlohmann::ordered_json value);

}  // namespace hybrid
