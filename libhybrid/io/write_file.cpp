// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/write_file.h"

#include <filesystem>

#include "libhybrid/core/error.h"
#include "libhybrid/io/file_group.h"
#include "libhybrid/io/file_writer.h"
#include "libhybrid/io/folders.h"

namespace hybrid {

void write_file(const std::string& path, std::string_view content) {
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  if (!folder.empty() && !name_exists(folder)) {
    throw Error("cannot write '" + path + "': there is no folder '" + folder.string() + "'");
  }
  FileGroup group(path);
  const std::string name = std::filesystem::path(path).filename().string();
  FileWriter file(group.stage(name), path);
  file.write(content);
  file.close();
  group.commit();
}

}  // namespace hybrid
