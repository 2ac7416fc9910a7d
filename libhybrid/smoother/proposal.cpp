// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/proposal.h"

#include <sstream>

#include "libhybrid/smoother/transaction.h"

namespace hybrid {
namespace {

/// The report of a trial that has left nothing behind but its work: the objective is what it was.
UpdateReport turned_down(const UpdateReport& trial, double rise, double allowed_rise) {
  UpdateReport report;
  static_cast<UpdateWork&>(report) = trial;
  report.flips = 0;
  report.status = UpdateReport::Status::kTurnedDown;
  std::ostringstream message;
  message << "the objective would rise by " << rise << ", where " << allowed_rise << " is allowed";
  report.message = message.str();
  report.objective_after = report.objective_before;
  return report;
}

}  // namespace

UpdateReport propose(IncrementalSmoother& smoother, const Proposal& proposal) {
  Transaction trial(smoother);
  // What earlier updates have left undone is no part of what the change is judged by.
  UpdateReport report = smoother.settle();
  if (report.status != UpdateReport::Status::kOk) return report;
  const double settled = smoother.objective();
  if (!proposal.moved.empty()) {
    report.go_on(smoother.move(proposal.moved));
    if (report.status != UpdateReport::Status::kOk) return report;
  }
  const UpdateReport change = smoother.update(proposal.delta);
  report.go_on(change);
  if (report.status != UpdateReport::Status::kOk) return report;
  report.handles = change.handles;
  report.go_on(smoother.settle());
  if (report.status != UpdateReport::Status::kOk) return report;
  report.objective_after = smoother.objective();
  const double rise = report.objective_after - settled;
  if (!(rise <= proposal.allowed_rise)) return turned_down(report, rise, proposal.allowed_rise);
  trial.commit();
  return report;
}

}  // namespace hybrid
