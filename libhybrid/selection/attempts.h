// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <set>
#include <utility>

#include "libhybrid/smoother/transaction.h"

namespace HYBRID_API hybrid {

/// An update on the way of a larger change that the smoother has refused, and with it all of the
/// transaction.
struct Refused {
  UpdateReport report;
};

/// The report of an update that was taken. Throws Refused where it was not.
inline UpdateReport taken(UpdateReport report) {
  if (report.status != UpdateReport::Status::kOk) throw Refused{std::move(report)};
  return report;
}

/// A change that consists of several updates of a smoother, and of attempts among them that are
/// left out where they would leave variables undetermined. It is made as a whole: where it fails,
/// the smoother is as it was before, by its transaction.
class Attempts {
 public:
  /// Names what is attempted.
  using Name = std::pair<std::size_t, int>;

  /// Runs part() and returns true; false, and nothing done, where the smoother refuses it.
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

  /// Runs change(report) in a transaction, from the start again without an attempt that was
  /// refused. `save()` is what else belongs to the state; restore(saved), which must not throw, is
  /// called where the change throws or its report is one of failure.
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
