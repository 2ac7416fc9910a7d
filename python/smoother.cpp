// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/smoother/proposal.h"
#include "libhybrid/smoother/window.h"
#include "python/calls.h"
#include "python/fields.h"

namespace hybrid::python {
namespace {

py::object value_at(const IncrementalSmoother& smoother, Key key) {
  const Values& values = smoother.values();
  const int slot = values.slot(key);
  return value_of(values.type(slot), values.data(slot));
}

void bind_reports(py::module_& m) {
  FieldsClass<UpdateReport> report(m, "UpdateReport", "The report of an update of a smoother.");
  report.kept("status", &UpdateReport::status)
      .kept("relinearized", &UpdateReport::relinearized)
      .kept("eliminated", &UpdateReport::eliminated)
      .kept("pending", &UpdateReport::pending)
      .kept("flips", &UpdateReport::flips)
      .kept("rounds", &UpdateReport::rounds)
      .kept("exact", &UpdateReport::exact)
      .kept("objective_before", &UpdateReport::objective_before)
      .kept("objective_after", &UpdateReport::objective_after)
      .kept("seconds", &UpdateReport::seconds)
      .def_property_readonly(
          "ok", [](const UpdateReport& r) { return r.status == UpdateReport::Status::kOk; },
          "False if the system is singular: then nothing has changed.")
      .def_readonly("message", &UpdateReport::message)
      .def_readonly("under_constrained", &UpdateReport::under_constrained,
                    "A variable that the factors do not determine, unless ok.")
      .def_readonly("handles", &UpdateReport::handles, "Handles of the added factors.")
      .def_readonly("objectives", &UpdateReport::objectives,
                    "Objective after every half-step (eq. 10), never rising.")
      .def_property_readonly("relinearized", [](const UpdateReport& r) { return r.relinearized; })
      .def_property_readonly("eliminated", [](const UpdateReport& r) { return r.eliminated; })
      .def_property_readonly(
          "pending", [](const UpdateReport& r) { return r.pending; },
          "Factors that wait to be eliminated.")
      .def_property_readonly(
          "flips", [](const UpdateReport& r) { return r.flips; },
          "Discrete variables whose value changed.")
      .def_property_readonly("rounds", [](const UpdateReport& r) { return r.rounds; })
      .def_readonly("open", &UpdateReport::open,
                    "By how much linear models are off that the next update makes again.")
      .def_property_readonly("exact", [](const UpdateReport& r) { return r.exact; })
      .def_property_readonly("objective_before",
                             [](const UpdateReport& r) { return r.objective_before; })
      .def_property_readonly("objective_after",
                             [](const UpdateReport& r) { return r.objective_after; })
      .def_property_readonly("seconds", [](const UpdateReport& r) { return r.seconds; });
  FieldsClass<WindowReport, UpdateReport>(m, "WindowReport", "The report of an update of a window.")
      .def_readonly("marginalized", &WindowReport::marginalized)
      .def_readonly("left", &WindowReport::left, "Continuous variables that were marginalised.")
      .def_readonly("left_discrete", &WindowReport::left_discrete)
      .def_readonly("undetermined", &WindowReport::undetermined)
      .def_readonly("kept", &WindowReport::kept,
                    "Variables that could not be marginalised; see kept_because.")
      .def_readonly("kept_because", &WindowReport::kept_because);
}

void bind_smoother_options(py::module_& m) {
  SettingsClass<SmootherOptions>(m, "SmootherOptions", "Settings of the incremental smoother.")
      .described();
}

/// What a smoother holds, as copies.
void bind_estimate_of(py::class_<IncrementalSmoother>& c) {
  using Smoother = IncrementalSmoother;
  c.def("__getitem__", looking(&value_at), "key"_a, "The estimate of a continuous variable.")
      .def("__contains__",
           looking(+[](const Smoother& s, Key k) { return s.values().contains(k); }), "key"_a)
      .def("__len__", looking(+[](const Smoother& s) { return s.values().size(); }))
      .def("graph", looking(+[](const Smoother& s) { return HybridGraph(s.graph()); }),
           "A copy of the graph.")
      .def("values", looking(+[](const Smoother& s) { return Values(s.values()); }),
           "A copy of the values.")
      .def("assignment", looking(+[](const Smoother& s) { return Assignment(s.assignment()); }),
           "A copy of the assignment.")
      .def("estimate", looking(+[](const Smoother& s) { return s.estimate(); }),
           "A copy of the estimate.")
      .def("factors_of", looking(+[](const Smoother& s, Key key) { return s.factors_of(key); }),
           "key"_a, "Handles of the factors of a continuous variable.")
      .def("__copy__", looking(+[](const Smoother& s) { return Smoother(s); }),
           "An independent copy of the smoother.")
      .def("__deepcopy__", looking(+[](const Smoother& s, const py::dict&) { return Smoother(s); }),
           "memo"_a)
      .def("__repr__", looking(+[](const Smoother& s) {
             return "<IncrementalSmoother of " + std::to_string(s.values().size()) +
                    " variables and " + std::to_string(s.graph().size()) + " factors>";
           }));
}

UpdateReport propose_change(IncrementalSmoother& smoother, const Delta& delta,
                            double allowed_rise) {
  return propose(smoother, {delta, allowed_rise});
}

void bind_incremental(py::module_& m) {
  using Smoother = IncrementalSmoother;
  py::class_<Smoother> c(
      m, "IncrementalSmoother",
      "Online alternating minimisation: the cost of an update depends on the variables it affects, "
      "the joint objective never rises, and a change is applied as a whole or not at all.");
  c.def(py::init<const SmootherOptions&>(), "options"_a = SmootherOptions())
      .def("update", changing(py::overload_cast<const Delta&>(&Smoother::update)), "delta"_a,
           "Applies a change. Raises Error for bad input; for a singular system, the report is not "
           "ok.")
      .def("converge", changing(&Smoother::converge), "max_rounds"_a = 50, "tolerance"_a = 1e-10,
           "Relinearises everything and alternates to convergence.")
      .def("settle", changing(&Smoother::settle), "max_updates"_a = 50,
           "Goes on where the last update has stopped, at the cost of what still moves.")
      .def("propose", changing(&propose_change), "delta"_a, "allowed_rise"_a,
           "Makes a change on trial: the map settles, and keeps it if the objective rises by no "
           "more than allowed. Else nothing has changed, and the report is not ok.")
      .def("begin", changing(&Smoother::begin),
           "Begins a transaction, which `commit` or `roll_back` ends.")
      .def("commit", changing(&Smoother::commit))
      .def("roll_back", changing(&Smoother::roll_back))
      .def("keep_last", changing(&Smoother::keep_last), "keys"_a,
           "Sets the variables to eliminate after all others.")
      .def("objective", reading(&Smoother::objective), "Objective of eq. 6 at the estimate.")
      .def("cost", reading(&Smoother::cost), "Half the weighted squared error.")
      .def("joint_covariance",
           reading(
               py::overload_cast<const std::vector<Key>&>(&Smoother::joint_covariance, py::const_)),
           "keys"_a, "Joint covariance of continuous variables, in the given order (eq. 11b).")
      .def(
          "joint_covariance",
          reading(py::overload_cast<const std::vector<Key>&, const Eigen::MatrixXd&>(
              &Smoother::joint_covariance, py::const_)),
          "keys"_a, "J"_a,
          "Covariance of J x, with x the tangents of the variables stacked: precise where x itself "
          "is not, as that of places relative to each other at the end of a long way.");
  bind_estimate_of(c);
}

void bind_window(py::module_& m) {
  py::enum_<WindowOptions::Mode>(m, "WindowMode")
      .value("FULL", WindowOptions::Mode::kFull)
      .value("FIXED_LAG", WindowOptions::Mode::kFixedLag)
      .value("FILTER", WindowOptions::Mode::kFilter)
      .value("BOUNDED", WindowOptions::Mode::kBounded);
  SettingsClass<WindowOptions>(m, "WindowOptions", "What of the past stays in the graph.")
      .described();
  py::class_<WindowSmoother>(m, "WindowSmoother",
                             "The incremental smoother over a window: old states are marginalised.")
      .def(py::init<const WindowOptions&, const SmootherOptions&>(), "window"_a = WindowOptions(),
           "options"_a = SmootherOptions())
      .def("update", changing(&WindowSmoother::update), "delta"_a)
      .def("converge", changing(&WindowSmoother::converge), "max_rounds"_a = 50,
           "tolerance"_a = 1e-10)
      .def_property_readonly("smoother", &WindowSmoother::smoother,
                             py::return_value_policy::reference_internal,
                             "The smoother, to read; update the window, not the smoother.")
      .def("past", looking(+[](const WindowSmoother& w) { return Estimate(w.past()); }),
           "Last estimates of the variables that have left, a copy.")
      .def_property_readonly("divergence",
                             looking(+[](const WindowSmoother& w) { return w.divergence(); }),
                             "What a bounded window has lost so far [nat].");
}

}  // namespace

void bind_smoother(py::module_& m) {
  bind_reports(m);
  bind_smoother_options(m);
  bind_incremental(m);
  bind_window(m);
}

}  // namespace hybrid::python
