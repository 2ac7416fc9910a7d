// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/bridge/log_files.h"

#include <system_error>

namespace hybrid {
namespace {

constexpr std::array kSuffixes{kTrueMapSuffix,          kTruePathSuffix,   kTruePositionsSuffix,
                               kTrueAssociationsSuffix, kTrueMoversSuffix, kTrueModesSuffix,
                               kTrueFixesSuffix,        kIdNamesSuffix,    kHeldOutFixesSuffix};

std::filesystem::path images_of(const std::string& rawlog) {
  const std::filesystem::path log(rawlog);
  const auto own = log.parent_path() / (log.stem().string() + "_Images");
  std::error_code error;
  return std::filesystem::is_directory(own, error) ? own : log.parent_path() / "Images";
}

}  // namespace

std::optional<std::filesystem::path> named_file(const std::string& name, const std::string& rawlog,
                                                std::uintmax_t most) {
  if (name != std::filesystem::path(name).filename() || name == "..") return std::nullopt;
  const std::filesystem::path file = images_of(rawlog) / name;
  // Of a folder, the size that a reader makes room for is no size; for a pipe it would wait.
  std::error_code error;
  const bool is_regular =
      std::filesystem::symlink_status(file, error).type() == std::filesystem::file_type::regular;
  if (!is_regular || std::filesystem::file_size(file, error) > most || error) return std::nullopt;
  return file;
}

LogFiles::LogFiles(const std::string& path, int level)
    : path_(path),
      name_(std::filesystem::path(path).filename().string()),
      stem_(std::filesystem::path(path).stem().string()),
      group_(path),
      log_(group_.stage(name_), level, path) {}

std::filesystem::path LogFiles::path_beside(std::string_view suffix) const {
  return group_.target(stem_ + std::string(suffix));
}

std::filesystem::path LogFiles::stage_beside(std::string_view suffix) const {
  return group_.stage(stem_ + std::string(suffix));
}

std::vector<std::string> LogFiles::commit() {
  log_.close();
  std::vector<std::string> all{path_}, former;
  for (const std::string& name : group_.staged()) {
    if (name != name_) all.push_back(group_.target(name).string());
  }
  std::error_code ignored;
  if (std::filesystem::exists(path_, ignored)) {
    for (const std::string_view suffix : kSuffixes) former.push_back(stem_ + std::string(suffix));
  }
  group_.commit(former);
  return all;
}

}  // namespace hybrid
