// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/bridge/output_directory.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <deque>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/io/exchange_folders.h"
#include "libhybrid/io/file_writer.h"
#include "libhybrid/io/folders.h"
#include "libhybrid/io/regular_file.h"
#include "mrpt_plugins/bridge/sha256.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSummary = "summary.json";

std::string text_of(const nlohmann::ordered_json& summary) {
  return summary.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + '\n';
}

fs::path checked(const fs::path& folder) {
  if (folder.empty()) throw Error("the output folder has an empty name");
  std::error_code ignored;
  if (name_exists(folder) && !fs::is_directory(folder, ignored)) {
    throw Error(fmt::format("cannot create the output folder '{}': a file of that name exists",
                            folder.string()));
  }
  return folder;
}

/// Renames a file that is not part of the former result but has the name of a new one. The
/// destructor restores it unless settle() was called.
class SetAside {
 public:
  explicit SetAside(const fs::path& path) : path_(path), aside_(path.string() + "~") {
    for (int i = 2; name_exists(aside_); ++i) aside_ = fmt::format("{}~{}", path.string(), i);
    is_link_ = ::link(path_.c_str(), aside_.c_str()) == 0;  // keeps the old name valid
    if (!is_link_ && std::rename(path_.c_str(), aside_.c_str()) != 0) {
      throw SystemError(fmt::format("cannot keep '{}'", path_.string()), errno);
    }
  }
  SetAside(const SetAside&) = delete;
  SetAside& operator=(const SetAside&) = delete;
  ~SetAside() {
    if (is_settled_) return;
    if (is_link_) {
      ::unlink(aside_.c_str());
    } else {
      std::rename(aside_.c_str(), path_.c_str());
    }
  }

  /// Message for the user.
  std::string text() const {
    return fmt::format("'{}' was not of a former result; it is now '{}'", path_.string(),
                       aside_.string());
  }
  /// Keeps the new name.
  void settle() noexcept { is_settled_ = true; }

 private:
  fs::path path_, aside_;
  bool is_link_ = false;
  bool is_settled_ = false;
};

/// The files that a summary.json lists; empty if it is not the summary of a result.
std::optional<nlohmann::json> listed_files(const fs::path& path) {
  if (!fs::is_regular_file(path)) return std::nullopt;
  const auto summary = nlohmann::json::parse(read_file(path.string()), nullptr, false);
  if (!summary.is_object() || !summary.contains("status")) return std::nullopt;
  return summary.value("files", nlohmann::json());
}

}  // namespace

OutputDirectory::OutputDirectory(const fs::path& folder, std::vector<std::string> own)
    : folder_(checked(folder)), own_(std::move(own)), group_(folder_ / kSummary, folder_) {
  remove_exchanged(folder_);
}

void OutputDirectory::write(const std::string& name, std::string_view content) const {
  FileWriter file(group_.stage(name), folder_ / name);
  file.write(content);
  file.close();
}

std::unique_ptr<FileWriter> OutputDirectory::open(const std::string& name) const {
  return std::make_unique<FileWriter>(group_.stage(name), folder_ / name);
}

void OutputDirectory::save(const std::string& name,
                           const std::function<void(const std::string&)>& save) const {
  const fs::path path = group_.stage(name);
  const std::string shown = (folder_ / name).string();
  try {
    save(path.string());
  } catch (const std::exception& e) {
    throw Error(fmt::format("cannot write '{}': {}", shown, e.what()));
  }
  std::error_code ignored;
  if (!fs::is_regular_file(fs::symlink_status(path, ignored))) {
    throw Error(fmt::format("cannot write '{}': nothing was written", shown));
  }
}

std::vector<std::string> OutputDirectory::publish(nlohmann::ordered_json summary) {
  summary["files"] = nlohmann::ordered_json::array();
  for (const std::string& name : group_.staged()) {
    if (is_own(name)) continue;
    summary["files"].push_back({{"path", name}, {"sha256", sha256_of_file(group_.stage(name))}});
  }
  write(kSummary, text_of(summary));
  summary = nullptr;

  const std::vector<std::string> former = former_files();
  if (own_.empty() && holds_only(former) && group_.exchange(former)) return {};
  std::deque<SetAside> others;
  std::vector<std::string> told;
  for (const std::string& name : group_.staged()) {
    const bool former_one = std::binary_search(former.begin(), former.end(), name);
    if (former_one || is_own(name) || !name_exists(folder_ / name)) continue;
    others.emplace_back(folder_ / name);
    told.push_back(others.back().text());
  }
  group_.commit(former);
  for (SetAside& other : others) other.settle();
  return told;
}

/// Files of the former result, sorted. Results of older versions list no files: the names of the
/// new files stand in for them.
std::vector<std::string> OutputDirectory::former_files() const {
  const auto listed = listed_files(folder_ / kSummary);
  if (!listed) return {};
  std::vector<std::string> names{kSummary};
  if (!listed->is_array()) names = group_.staged();
  for (const auto& file : *listed) {
    if (!file.is_object() || !file.contains("path") || !file["path"].is_string()) continue;
    const auto name = file["path"].get<std::string>();
    if (FileGroup::is_name(name) && !is_own(name)) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

bool OutputDirectory::is_own(const std::string& name) const {
  return std::find(own_.begin(), own_.end(), name) != own_.end();
}

/// Whether the folder, or its subfolder `below`, holds only these files and their folders.
bool OutputDirectory::holds_only(const std::vector<std::string>& former,
                                 const std::string& below) const {
  for (const FolderEntry& entry : entries_of(folder_ / below)) {
    const std::string name = below + entry.name + (entry.is_folder ? "/" : "");
    if (name == fmt::format(".{}.part/", kSummary)) continue;
    const auto it = std::lower_bound(former.begin(), former.end(), name);
    if (it == former.end()) return false;
    if (!entry.is_folder && *it != name) return false;
    if (entry.is_folder && (it->rfind(name, 0) != 0 || !holds_only(former, name))) return false;
  }
  return true;
}

void amend_summary(const fs::path& folder, const std::string& key, nlohmann::ordered_json value) {
  FileGroup group(folder / kSummary);
  std::ifstream file(group.target(kSummary));
  auto summary = nlohmann::ordered_json::parse(file, nullptr, false);
  if (!summary.is_object()) {
    throw Error(fmt::format("'{}' cannot be read", group.target(kSummary).string()));
  }
  summary[key] = std::move(value);
  FileWriter out(group.stage(kSummary), group.target(kSummary));
  out.write(text_of(summary));
  out.close();
  group.commit();
}

}  // namespace hybrid
