// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/proposal.h"

#include <sstream>

#include "libhybrid/smoother/transaction.h"

namespace hybrid {
namespace {

/// The report of a trial that has left nothing behind but its work.
UpdateReport turned_down(const UpdateReport& trial, double before, double allowed_rise) {
  UpdateReport report;
  static_cast<UpdateWork&>(report) = trial;
  report.flips = 0;
  report.status = UpdateReport::Status::kTurnedDown;
  std::ostringstream message;
  message << "the objective would rise by " << trial.objective_after - before << ", where "
          << allowed_rise << " is allowed";
  report.message = message.str();
  report.objective_before = report.objective_after = before;
  return report;
}

}  // namespace

UpdateReport propose(IncrementalSmoother& smoother, const Proposal& proposal) {
  const double before = smoother.objective();
  Transaction trial(smoother);
  UpdateReport report = smoother.update(proposal.delta);
  if (report.status != UpdateReport::Status::kOk) return report;
  report.go_on(smoother.settle());
  if (report.status != UpdateReport::Status::kOk) return report;
  report.objective_after = smoother.objective();
  if (!(report.objective_after - before <= proposal.allowed_rise))
    return turned_down(report, before, proposal.allowed_rise);
  trial.commit();
  return report;
}

}  // namespace hybrid
