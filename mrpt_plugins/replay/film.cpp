// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/replay/detail/film.h"

#include <fmt/format.h>

#include <filesystem>
#include <vector>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/output/video.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

}  // namespace

Film::Film(const std::string& path, const OutputDirectory& out) : path_(path), out_(out) {
  if (path.empty()) return;
  const fs::path file(path);
  if (file.extension() != ".mp4") {
    throw Error(fmt::format("cannot write '{}': the name of a video ends in .mp4", path));
  }
  name_ = file.filename().string();
  if (const fs::path folder = file.parent_path(); !folder.empty()) {
    if (!fs::is_directory(folder)) {
      throw Error(fmt::format("cannot write '{}': there is no folder '{}'", path, folder.string()));
    }
    if (!fs::equivalent(folder, out.folder())) group_.emplace(file);
  }
  const auto black = [](int) { return Image{64, 64, std::vector<std::uint8_t>(64 * 64 * 3)}; };
  encode(1, black);
}

std::string Film::encode(int count, const std::function<Image(int)>& picture) const {
  if (!group_) {
    std::string note;
    out_.save(name_, [&](const std::string& file) { note = encode_video(file, count, picture); });
    return note;
  }
  try {
    return encode_video(group_->stage(name_), count, picture);
  } catch (const std::exception& e) {
    throw Error(fmt::format("cannot write '{}': {}", path_, e.what()));
  }
}

void Film::commit() {
  if (group_) group_->commit();
}

void Film::undo() {
  if (group_) group_->undo();
}

}  // namespace hybrid
