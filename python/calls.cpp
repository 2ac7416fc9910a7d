// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "python/calls.h"

namespace hybrid::python {
namespace {

struct Users {
  int reading = 0, changing = 0;
};

/// By smoother; entries are there while calls run.
std::map<const IncrementalSmoother*, Users>& users() {
  static std::map<const IncrementalSmoother*, Users> all;
  return all;
}

}  // namespace

SmootherInUse::SmootherInUse(const IncrementalSmoother& smoother, Kind kind)
    : smoother_(&smoother), kind_(kind) {
  const Users now = is_changing(smoother) ? Users{0, 1} : users()[smoother_];
  if (now.changing > 0 || (kind == Kind::kChange && now.reading > 0)) {
    throw Error(
        "the smoother is in use by a call that has not returned, in another thread or as the "
        "caller of this factor: wait for it, or use a copy of the smoother");
  }
  Users& mine = users()[smoother_];
  ++(kind == Kind::kChange ? mine.changing : mine.reading);
}

SmootherInUse::~SmootherInUse() {
  const auto mine = users().find(smoother_);
  --(kind_ == Kind::kChange ? mine->second.changing : mine->second.reading);
  if (mine->second.reading + mine->second.changing == 0) users().erase(mine);
}

bool SmootherInUse::is_changing(const IncrementalSmoother& smoother) {
  const auto it = users().find(&smoother);
  return it != users().end() && it->second.changing > 0;
}

}  // namespace hybrid::python
