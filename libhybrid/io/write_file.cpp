// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/write_file.h"

#include <filesystem>
#include <fstream>
#include <system_error>

#include "libhybrid/core/error.h"

namespace hybrid {

void write_file(const std::string& path, std::string_view content) {
  const std::string temporary = path + ".partial";
  std::ofstream out(temporary, std::ios::binary);
  out.write(content.data(), static_cast<std::streamsize>(content.size()));
  out.close();
  std::error_code error;
  if (out) std::filesystem::rename(temporary, path, error);
  if (!out || error) {
    std::error_code ignored;
    std::filesystem::remove(temporary, ignored);
    throw Error(path + ": cannot be written");
  }
}

}  // namespace hybrid
