// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/bridge/log_files.h"

#include <system_error>

namespace hybrid {
namespace {

constexpr std::array kSuffixes{kTrueMapSuffix,          kTruePathSuffix,   kTruePositionsSuffix,
                               kTrueAssociationsSuffix, kTrueMoversSuffix, kTrueModesSuffix,
                               kTrueFixesSuffix,        kIdNamesSuffix,    kHeldOutFixesSuffix};

}  // namespace

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
