// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libhybrid/io/file_group.h"
#include "mrpt_plugins/bridge/gzip_writer.h"

namespace HYBRID_API hybrid {

/// Suffixes of the ground truth files beside F.rawlog, of the names that its ids stand for, and of
/// satellite fixes that are kept from it.
inline constexpr std::string_view kTrueMapSuffix = "_ground_truth.txt";
inline constexpr std::string_view kTruePathSuffix = "_ground_truth_robot_path.txt";
inline constexpr std::string_view kTruePositionsSuffix = "_ground_truth_robot_path.xyz";
inline constexpr std::string_view kTrueAssociationsSuffix = "_ground_truth_associations.csv";
inline constexpr std::string_view kTrueMoversSuffix = "_ground_truth_movers.csv";
inline constexpr std::string_view kTrueModesSuffix = "_ground_truth_modes.txt";
inline constexpr std::string_view kTrueFixesSuffix = "_ground_truth_fixes.csv";
inline constexpr std::string_view kIdNamesSuffix = "_ids.csv";
inline constexpr std::string_view kHeldOutFixesSuffix = "_held_out_fixes.xyz";

/// Where a file lies that a log names: in the folder F_Images, or else Images, beside F.rawlog.
/// Nothing unless the name is one of a regular file there, no link, of at most `most` bytes: a log
/// may come from anybody, and a link may lead anywhere.
std::optional<std::filesystem::path> named_file(const std::string& name, const std::string& rawlog,
                                                std::uintmax_t most);

/// A rawlog and the files beside it. commit() shows all of them at once and removes those of an
/// older log of that name; without it, nothing changes. Throws Error that names the file.
class LogFiles {
 public:
  /// `path` is F.rawlog; its folder is created if absent. `level` is zlib's compression level, 1 to
  /// 9.
  LogFiles(const std::string& path, int level);

  GzipWriter& log() { return log_; }
  /// Path of F_SUFFIX: the final one, and the one to write to before commit().
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
