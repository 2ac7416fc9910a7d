// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <functional>
#include <optional>
#include <string>

#include "libhybrid/io/file_group.h"
#include "mrpt_plugins/bridge/output_directory.h"
#include "mrpt_plugins/drawing/image.h"

namespace hybrid {

/// The video that a replay writes: one of the files of the result, where it is to be in their
/// folder, as a name without a folder is, else a result beside.
class Film {
 public:
  /// Tries whether it can be written, before long work; an empty path is no film. `out` must live
  /// as long as this. Throws Error that names the file.
  Film(const std::string& path, const OutputDirectory& out);

  bool wanted() const { return !path_.empty(); }
  /// Encodes the pictures 0 .. count-1; returns a warning, or "".
  std::string encode(int count, const std::function<Image(int)>& picture) const;

  /// Shows the film, where that is not for the result to do; `undo` takes it back.
  void commit();
  void undo();

 private:
  std::string path_;
  const OutputDirectory& out_;
  std::string name_;
  std::optional<FileGroup> group_;  // of a film that is not in the folder of the result
};

}  // namespace hybrid
