// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace hybrid {

/// A folder that only ever shows complete files: each is written under a temporary name in the same
/// folder, flushed, checked and renamed. On failure the temporary file is removed, an older file of
/// the same name stays as it was, and std::runtime_error names the path and the reason.
class OutputDirectory {
 public:
  /// Creates the folder and its parents if absent; throws if that or writing into it is impossible.
  explicit OutputDirectory(std::filesystem::path folder);

  const std::filesystem::path& folder() const { return folder_; }

  /// Writes `content` (text or bytes) as the file `name`, which must be a plain file name.
  void write(const std::string& name, std::string_view content) const;

  /// For writers that want a path: `save` gets a temporary path with the extension of `name`, and
  /// throws if it fails.
  void save(const std::string& name, const std::function<void(const std::string&)>& save) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace hybrid
