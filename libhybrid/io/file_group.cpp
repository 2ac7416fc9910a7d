// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/file_group.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <set>
#include <sstream>

#include "libhybrid/core/error.h"
#include "libhybrid/io/exchange_folders.h"
#include "libhybrid/io/file_writer.h"
#include "libhybrid/io/folders.h"
#include "libhybrid/io/regular_file.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, int code) {
  throw SystemError("cannot write '" + path.string() + "'", code);
}

/// Throws SystemError that names `shown`.
void make_folders(const fs::path& folder, const fs::path& shown) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) fail(shown, error.value());
}

void move_file(const fs::path& from, const fs::path& to, const fs::path& shown) {
  if (std::rename(from.c_str(), to.c_str()) != 0) fail(shown, errno);
}

/// Throws Error for an empty file name, a folder or another existing path that is not a regular
/// file.
fs::path checked(const fs::path& main) {
  if (!main.has_filename()) throw Error("cannot write '" + main.string() + "': names no file");
  std::error_code ignored;
  const fs::file_status status = fs::status(main, ignored);
  if (fs::is_directory(status)) throw Error("cannot write '" + main.string() + "': is a folder");
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw Error("cannot write '" + main.string() + "': is not a regular file");
  }
  return main;
}

bool is_link(const fs::path& path) {
  std::error_code ignored;
  return fs::is_symlink(fs::symlink_status(path, ignored));
}

/// The first folder on the way from `folder` to the file `name` that is a link, which may lead
/// anywhere; empty if none is.
fs::path link_on_the_way(const fs::path& folder, const std::string& name) {
  fs::path at = folder;
  for (const fs::path& part : fs::path(name).parent_path()) {
    at /= part;
    if (is_link(at)) return at;
  }
  return {};
}

}  // namespace

FileGroup::CreatedFolders::CreatedFolders(const fs::path& folder) {
  for (fs::path at = folder; !at.empty() && !name_exists(at); at = at.parent_path()) {
    if (at.has_filename()) folders.insert(folders.begin(), at);
  }
  try {
    if (!folder.empty()) make_folders(folder, folder);
  } catch (...) {
    remove();
    throw;
  }
}

void FileGroup::CreatedFolders::remove() const {
  for (auto it = folders.rbegin(); it != folders.rend(); ++it) ::rmdir(it->c_str());
}

FileGroup::FileGroup(const fs::path& main, const fs::path& shown)
    : folder_(checked(main).parent_path()),
      main_(main.filename().string()),
      hidden_(folder_ / ("." + main_ + ".part")),
      created_(folder_),
      lock_(hidden_, shown.empty() ? main : shown) {
  for (const fs::path& folder : {fresh(), old()}) {
    if (is_link(folder)) ::unlink(folder.c_str());
  }
  recover();
  make_folders(fresh(), main);
}

FileGroup::~FileGroup() {
  if (state_ == State::kStaging || state_ == State::kCommitted) clear();
}

bool FileGroup::is_name(const std::string& name) {
  const fs::path path(name);
  return !name.empty() && path.is_relative() && path.has_filename() &&
         std::none_of(path.begin(), path.end(),
                      [](const fs::path& part) { return part == "." || part == ".."; });
}

/// Whether a name, perhaps of a journal or a summary that somebody else wrote, is of a file in the
/// folder or below it, and not of one elsewhere to which links lead.
bool FileGroup::is_ours(const std::string& name) const {
  return is_name(name) && link_on_the_way(folder_, name).empty() &&
         link_on_the_way(fresh(), name).empty() && link_on_the_way(old(), name).empty();
}

fs::path FileGroup::stage(const std::string& name) const {
  if (!is_name(name)) throw Error("cannot write '" + target(name).string() + "': no plain name");
  if (const fs::path link = link_on_the_way(folder_, name); !link.empty()) {
    throw Error("cannot write '" + target(name).string() + "': '" + link.string() +
                "' is a link, not a folder; remove it");
  }
  const fs::path path = fresh() / name;
  make_folders(path.parent_path(), target(name));
  return path;
}

std::vector<std::string> FileGroup::staged() const {
  return files_below(fresh());
}

void FileGroup::sync_staged() const {
  std::set<fs::path> folders{fresh()};
  for (const std::string& name : staged()) {
    const fs::path path = fresh() / name;
    sync_to_disk(path, target(name));
    folders.insert(path.parent_path());
  }
  for (const fs::path& folder : folders) sync_to_disk(folder, target(main_));
}

std::vector<FileGroup::Move> FileGroup::plan(const std::vector<std::string>& former) const {
  std::vector<Move> moves;
  const std::vector<std::string> names = staged();
  if (!std::binary_search(names.begin(), names.end(), main_)) {
    throw Error("cannot write '" + target(main_).string() + "': nothing was written");
  }
  for (const std::string& name : names) {
    std::error_code ignored;
    if (fs::is_directory(fs::symlink_status(target(name), ignored))) fail(target(name), EISDIR);
    moves.push_back({name, true, name_exists(target(name))});
  }
  for (const std::string& name : former) {
    if (std::binary_search(names.begin(), names.end(), name)) continue;
    if (is_ours(name) && name_exists(target(name))) moves.push_back({name, false, true});
  }
  return moves;
}

void FileGroup::commit(const std::vector<std::string>& former) {
  moves_ = plan(former);
  sync_staged();
  try {
    if (moves_.size() > 1) write_journal(moves_);
    apply(moves_);
    sync_targets(moves_);
  } catch (...) {
    take_back();
    throw;
  }
  state_ = State::kCommitted;
}

void FileGroup::undo() {
  if (state_ == State::kCommitted) take_back();
}

bool FileGroup::exchange(const std::vector<std::string>& former) {
  sync_staged();
  const auto place = exchange_folders(fresh(), shown_folder());
  if (!place) return false;
  state_ = State::kElsewhere;
  clear_old_folder(*place, former);
  lock_.abandon();
  return true;
}

/// Removes the old folder after an exchange. Files that others put there in the meantime move to
/// the new one.
void FileGroup::clear_old_folder(const fs::path& place,
                                 const std::vector<std::string>& former) const noexcept {
  try {
    remove_tree(place / hidden_.filename());
    for (const std::string& name : former) {
      ::unlink((place / name).c_str());
      remove_empty_folders(place, name);
    }
    for (const FolderEntry& entry : entries_of(place)) {
      const fs::path to = shown_folder() / entry.name;
      if (!name_exists(to)) std::rename((place / entry.name).c_str(), to.c_str());
    }
    ::rmdir(place.c_str());
  } catch (...) {  // what is left is cleared by the next process
  }
}

void FileGroup::recover() {
  if (name_exists(undo_journal())) {
    roll_back(read_journal(undo_journal()));
  } else if (name_exists(journal()) && name_exists(fresh() / main_)) {
    const std::vector<Move> moves = read_journal(journal());
    apply(moves);
    sync_targets(moves);
  }
  clear();
}

/// Writes for each move `+` or `-` for `comes`, the same for `replaces`, the name, and a zero byte.
void FileGroup::write_journal(const std::vector<Move>& moves) const {
  const fs::path unfinished = hidden_ / "journal.part";
  FileWriter file(unfinished, target(main_));
  for (const Move& move : moves) {
    file.write(move.comes ? "+" : "-");
    file.write(move.replaces ? "+" : "-");
    file.write(move.name);
    file.write(std::string_view("\0", 1));
  }
  file.close();
  sync_to_disk(unfinished, target(main_));
  move_file(unfinished, journal(), target(main_));
  sync_to_disk(hidden_, target(main_));
}

/// Entries that name no file of the folder are left out: a journal may come from anywhere.
std::vector<FileGroup::Move> FileGroup::read_journal(const fs::path& file) const {
  std::vector<Move> moves;
  std::istringstream in(read_file(file.string()));
  for (std::string entry; std::getline(in, entry, '\0');) {
    if (entry.size() < 3 || !is_ours(entry.substr(2))) continue;
    moves.push_back({entry.substr(2), entry[0] == '+', entry[1] == '+'});
  }
  return moves;
}

/// May be called again after it was interrupted at any point.
void FileGroup::apply(const std::vector<Move>& moves) const {
  const auto is_main = [&](const Move& move) { return move.name == main_; };
  for (const Move& move : moves) {
    if (is_main(move)) keep(move, moves.size() > 1);
  }
  for (const Move& move : moves) {
    if (!move.comes) keep(move, true);
  }
  for (const Move& move : moves) {
    if (!move.comes || is_main(move)) continue;
    keep(move, false);
    bring(move);
  }
  for (const Move& move : moves) {
    if (is_main(move)) bring(move);
  }
}

/// Saves the present file among the old ones. Unless it must go `away`, it also stays in place, if
/// the file system has hard links, until a new one replaces it.
void FileGroup::keep(const Move& move, bool away) const {
  const fs::path from = target(move.name), to = old() / move.name;
  if (!move.replaces || name_exists(to) || !name_exists(from)) return;
  make_folders(to.parent_path(), from);
  if (!away && ::link(from.c_str(), to.c_str()) == 0) return;
  move_file(from, to, from);
}

void FileGroup::bring(const Move& move) const {
  const fs::path from = fresh() / move.name, to = target(move.name);
  if (!name_exists(from)) return;
  if (to.has_parent_path()) make_folders(to.parent_path(), to);
  move_file(from, to, to);
}

void FileGroup::take_back() {
  state_ = State::kStuck;
  if (name_exists(journal())) move_file(journal(), undo_journal(), target(main_));
  roll_back(moves_);
  sync_targets(moves_);
  state_ = State::kStaging;
}

/// May be called again after it was interrupted at any point.
void FileGroup::roll_back(const std::vector<Move>& moves) const {
  for (auto it = moves.rbegin(); it != moves.rend(); ++it) {
    const fs::path to = target(it->name);
    if (name_exists(old() / it->name)) {
      move_file(old() / it->name, to, to);
    } else if (it->comes && !it->replaces && !name_exists(fresh() / it->name)) {
      if (::unlink(to.c_str()) != 0 && errno != ENOENT) fail(to, errno);
    }
    if (it->comes) remove_empty_folders(folder_, it->name);
  }
}

void FileGroup::sync_targets(const std::vector<Move>& moves) const {
  std::set<fs::path> folders{shown_folder()};
  for (const Move& move : moves) {
    const fs::path parent = target(move.name).parent_path();
    if (move.comes && !parent.empty()) folders.insert(parent);
  }
  for (const fs::path& folder : folders) {
    if (name_exists(folder)) sync_to_disk(folder);
  }
}

void FileGroup::clear() noexcept {
  try {
    for (const fs::path& path : {journal(), undo_journal(), hidden_ / "journal.part"}) {
      ::unlink(path.c_str());
    }
    remove_tree(old());
    remove_tree(fresh());
    for (const Move& move : moves_) {
      if (!move.comes) remove_empty_folders(folder_, move.name);
    }
  } catch (...) {  // what is left is cleared by the next process
  }
}

}  // namespace hybrid
