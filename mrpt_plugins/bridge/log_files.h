// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "libhybrid/io/file_group.h"
#include "mrpt_plugins/bridge/gzip_writer.h"

namespace HYBRID_API hybrid {

/// Endings of the files beside F.rawlog that tell what is true of it.
inline constexpr std::string_view kTrueMapSuffix = "_ground_truth.txt";
inline constexpr std::string_view kTruePathSuffix = "_ground_truth_robot_path.txt";
inline constexpr std::string_view kTruePositionsSuffix = "_ground_truth_robot_path.xyz";
inline constexpr std::string_view kTrueAssociationsSuffix = "_ground_truth_associations.csv";
inline constexpr std::string_view kTrueModesSuffix = "_ground_truth_modes.txt";

/// A rawlog and the files of its truth, which are one thing: they appear together or not at all,
/// and those of an older log of that name go. Throws Error that names the file.
class LogFiles {
 public:
  /// `path` is F.rawlog; its folder is created if absent. `level` is that of the compression.
  LogFiles(const std::string& path, int level);

  GzipWriter& log() { return log_; }
  /// F_ENDING: where it will be, and where to write it until then.
  std::filesystem::path path_beside(std::string_view suffix) const;
  std::filesystem::path stage_beside(std::string_view suffix) const;

  /// Closes the log and shows all files. Returns their paths, the log first.
  std::vector<std::string> commit();

 private:
  std::string path_, name_, stem_;
  FileGroup group_;
  GzipWriter log_;
};

}  // namespace hybrid
