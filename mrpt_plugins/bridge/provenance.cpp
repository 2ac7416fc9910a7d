// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/bridge/provenance.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "libhybrid/io/regular_file.h"
#include "mrpt_plugins/bridge/sha256.h"

namespace hybrid {
namespace {

/// A warning for text files whose last line has no newline: the file may be cut off. INIs are
/// exempt, since people write them by hand.
std::string warning_of(const std::string& path) {
  if (std::filesystem::path(path).extension() == ".ini" || !ends_in_line(path)) return "";
  std::ifstream file(path, std::ios::binary);
  std::string end(64, ' ');
  const auto size = static_cast<std::streamoff>(std::filesystem::file_size(path));
  file.seekg(std::max<std::streamoff>(0, size - static_cast<std::streamoff>(end.size())));
  file.read(end.data(), static_cast<std::streamsize>(end.size()));
  const bool is_text = std::all_of(end.begin(), end.end(), [](char c) {
    return (c >= ' ' && c <= '~') || c == '\n' || c == '\r' || c == '\t';
  });
  return is_text ? "its last line has no end; is the file cut off?" : "";
}

}  // namespace

void Provenance::add_input(const std::string& path) {
  const bool known = std::any_of(inputs.begin(), inputs.end(),
                                 [&](const Input& input) { return input.path == path; });
  if (path.empty() || known) return;
  inputs.push_back({path, "", ""});
  if (!std::filesystem::is_regular_file(path)) return;
  inputs.back().sha256 = sha256_of_file(path);
  inputs.back().warning = warning_of(path);
}

nlohmann::ordered_json summary_start(const std::string& status, const std::string& message,
                                     const Provenance& provenance) {
  nlohmann::ordered_json out = {{"status", status}};
  if (!message.empty()) out["message"] = message;
  out["version"] = provenance.version;
  out["command"] = provenance.command;
  out["inputs"] = nlohmann::ordered_json::array();
  for (const Provenance::Input& input : provenance.inputs) {
    out["inputs"].push_back({{"path", input.path}, {"sha256", nullptr}});
    if (!input.sha256.empty()) out["inputs"].back()["sha256"] = input.sha256;
    if (!input.warning.empty()) out["inputs"].back()["warning"] = input.warning;
  }
  for (const auto& [section, keys] : provenance.configuration) {
    out["configuration"][section] = nlohmann::ordered_json::object();
    for (const auto& [key, value] : keys) out["configuration"][section][key] = value;
  }
  return out;
}

}  // namespace hybrid
