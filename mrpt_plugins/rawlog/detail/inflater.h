// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "mrpt_plugins/rawlog/decoder.h"

namespace hybrid {

/// A compression method, member by member.
class Inflater {
 public:
  enum class Step { kMore, kMemberEnds, kFault };

  virtual ~Inflater() = default;

  /// Whether these bytes begin a member; up to four are looked at.
  virtual bool begins(std::string_view head) const = 0;

  /// Forgets the member before.
  virtual void reset() = 0;

  /// Takes bytes from the front of `input` and appends the decoded ones at `to`, of which `room`
  /// are left; both are moved on.
  virtual Step step(std::string_view& input, char*& to, std::size_t& room) = 0;

  /// What the last fault was.
  virtual std::string fault() const = 0;
};

/// Throws std::bad_alloc where there is no memory for it. Null for kNone.
std::unique_ptr<Inflater> make_inflater(Compression compression);

}  // namespace hybrid
