// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <set>
#include <utility>

#include "libhybrid/smoother/transaction.h"

namespace HYBRID_API hybrid {

/// Thrown when the smoother refuses an update within a larger change, whose transaction is then
/// rolled back.
struct Refused {
  UpdateReport report;
};

/// Returns the report of an update; throws Refused if the smoother refused it.
inline UpdateReport taken(UpdateReport report) {
  if (report.status != UpdateReport::Status::kOk) throw Refused{std::move(report)};
  return report;
}

/// Makes a change that consists of several updates of a smoother; attempts among them are left out
/// if they would leave variables undetermined. The change is made as a whole: if it fails, its
/// transaction restores the smoother.
class Attempts {
 public:
  /// Identifies an attempt.
  using Name = std::pair<std::size_t, int>;

  /// Runs part() and returns true. If the smoother refuses it, the change starts again, and this
  /// attempt then returns false without running part().
  template <class Part>
  bool attempt(Name name, const Part& part) {
    if (left_out_.count(name) != 0) return false;
    try {
      part();
    } catch (const Refused&) {
      left_out_.insert(name);
      throw Again();
    }
    return true;
  }

  /// Runs change(report) in a transaction, and again without an attempt that was refused. `save()`
  /// returns the state outside the smoother; restore(saved), which must not throw, is called when
  /// the change fails or starts again.
  template <class Report, class Save, class Restore, class Change>
  Report run(IncrementalSmoother& smoother, const Save& save, const Restore& restore,
             const Change& change) {
    left_out_.clear();
    for (;;) {
      auto before = save();
      Report report;
      try {
        Transaction transaction(smoother);
        change(report);
        transaction.commit();
        return report;
      } catch (const Again&) {
        restore(std::move(before));
      } catch (const Refused& refused) {
        restore(std::move(before));
        static_cast<UpdateReport&>(report) = refused.report;
        return report;
      } catch (...) {
        restore(std::move(before));
        throw;
      }
    }
  }

 private:
  struct Again {};
  std::set<Name> left_out_;
};

}  // namespace hybrid
