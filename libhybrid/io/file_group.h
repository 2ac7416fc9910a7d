// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/io/write_lock.h"

namespace HYBRID_API hybrid {

/// Files that appear in a folder together or not at all. The others are meaningless without the
/// main one.
///
/// While a process writes the group of F there is a hidden folder `.F.part` beside F. It holds the
/// lock, the new files, and during the commit the old ones. If a process dies, the next one that
/// writes the group removes these files or, if the commit had begun, completes it: several renames
/// are not atomic together, so a journal lists them, and the main file is the first to be removed
/// and the last to be put in place.
///
/// All functions throw SystemError or Error that names the file.
class FileGroup {
 public:
  /// Creates the folder of `main` if it is absent, and takes the lock. If another process has the
  /// lock, the message names `shown`, or `main` if that is empty.
  explicit FileGroup(const std::filesystem::path& main, const std::filesystem::path& shown = {});
  FileGroup(const FileGroup&) = delete;
  FileGroup& operator=(const FileGroup&) = delete;
  /// Without a commit the files are as before.
  ~FileGroup();

  /// Whether a file of a group may have this name: relative, in the folder or one below it.
  static bool is_name(const std::string& name);

  /// The path at which to write the file `name` before the commit.
  std::filesystem::path stage(const std::string& name) const;
  /// The path of the file `name` after the commit.
  std::filesystem::path target(const std::string& name) const { return folder_ / name; }
  /// Names of the files that are staged, sorted.
  std::vector<std::string> staged() const;

  /// Replaces the files of the group by those staged, and removes the `former` ones that are not
  /// among these. On failure nothing has changed. Nothing can be staged afterwards.
  void commit(const std::vector<std::string>& former = {});
  /// Undoes a commit.
  void undo();

  /// Commits in one atomic step, by exchanging the folder, which must hold nothing but the `former`
  /// files, with that of the staged ones. False, with nothing changed, if the file system cannot do
  /// that. Cannot be undone.
  bool exchange(const std::vector<std::string>& former);

 private:
  /// Folders made for the group; those that stay empty are removed again.
  struct CreatedFolders {
    std::vector<std::filesystem::path> folders;  // outermost first
    explicit CreatedFolders(const std::filesystem::path& folder);
    ~CreatedFolders() { remove(); }
    void remove() const;
  };
  /// What the commit does with one name.
  struct Move {
    std::string name;
    bool comes = false;     // a new file is put in place; else the old one is removed
    bool replaces = false;  // there is an old file of that name
  };
  enum class State {
    kStaging,
    kCommitted,
    kElsewhere,  // the hidden folder has moved with the exchanged folder
    kStuck       // neither committed nor undone; left to the next process
  };

  std::filesystem::path fresh() const { return hidden_ / "new"; }
  std::filesystem::path old() const { return hidden_ / "old"; }
  std::filesystem::path journal() const { return hidden_ / "journal"; }
  std::filesystem::path undo_journal() const { return hidden_ / "undo"; }
  std::filesystem::path shown_folder() const { return folder_.empty() ? "." : folder_; }
  void recover();
  void sync_staged() const;
  std::vector<Move> plan(const std::vector<std::string>& former) const;
  void write_journal(const std::vector<Move>& moves) const;
  bool is_ours(const std::string& name) const;
  std::vector<Move> read_journal(const std::filesystem::path& file) const;
  void apply(const std::vector<Move>& moves) const;
  void keep(const Move& move, bool away) const;
  void bring(const Move& move) const;
  void take_back();
  void roll_back(const std::vector<Move>& moves) const;
  void sync_targets(const std::vector<Move>& moves) const;
  void clear_old_folder(const std::filesystem::path& place,
                        const std::vector<std::string>& former) const noexcept;
  void clear() noexcept;

  std::filesystem::path folder_;  // empty: the current one
  std::string main_;
  std::filesystem::path hidden_;
  CreatedFolders created_;
  WriteLock lock_;
  std::vector<Move> moves_;
  State state_ = State::kStaging;
};

}  // namespace hybrid
