// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/solvers/alternating.h"
#include "libhybrid/solvers/certificate.h"
#include "libhybrid/solvers/chordal.h"
#include "libhybrid/solvers/dogleg.h"
#include "libhybrid/solvers/exhaustive.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "libhybrid/solvers/null_space.h"
#include "python/bindings.h"

namespace hybrid::python {
namespace {

void bind_options(py::module_& m) {
  SettingsClass<SolverOptions>(m, "SolverOptions",
                               "When the continuous solvers stop, and how they start.")
      .field("max_iterations", &SolverOptions::max_iterations, "Linear systems solved at most.")
      .field("relative_decrease", &SolverOptions::relative_decrease,
             "Converged once a whole Gauss-Newton step lowers the cost by less than this share.")
      .field("gradient", &SolverOptions::gradient,
             "Converged once no variable's gradient exceeds this, in standard deviations.")
      .field("step", &SolverOptions::step,
             "Converged once no variable's step exceeds this, in standard deviations.")
      .field("initial_damping", &SolverOptions::initial_damping,
             "Of Levenberg-Marquardt, relative to the diagonal of the Hessian.")
      .field("initial_radius", &SolverOptions::initial_radius,
             "Of the dogleg, in standard deviations per unknown.")
      .field("threads", &SolverOptions::threads,
             "0: one per core, at most 4; the result is the same for any number.");
  SettingsClass<DiscreteOptions>(m, "DiscreteOptions", "How far exact discrete inference goes.")
      .field("local_search_when_too_large", &DiscreteOptions::local_search_when_too_large,
             "Where exact inference is too large; else that is an Error.")
      .field("max_sweeps", &DiscreteOptions::max_sweeps, "Of local search.");
  SettingsClass<AlternatingOptions>(m, "AlternatingOptions", "Settings of `alternate`.")
      .field("max_iterations", &AlternatingOptions::max_iterations, "Pairs of half-steps.")
      .field("relative_decrease", &AlternatingOptions::relative_decrease,
             "Converged once a pair of half-steps lowers the objective by less than this share.")
      .field("continuous_iterations", &AlternatingOptions::continuous_iterations,
             "Of each continuous half-step.")
      .field("continuous", &AlternatingOptions::continuous, "Of the continuous half-steps.")
      .field("discrete", &AlternatingOptions::discrete, "Of the discrete half-steps.");
}

void bind_reports(py::module_& m) {
  py::enum_<SolverStatus>(m, "SolverStatus", "How a solve ended.")
      .value("CONVERGED", SolverStatus::kConverged)
      .value("ITERATION_LIMIT", SolverStatus::kIterationLimit)
      .value("UNDER_CONSTRAINED", SolverStatus::kUnderConstrained)
      .value("NOT_FINITE", SolverStatus::kNotFinite)
      .value("STALLED", SolverStatus::kStalled);
  py::class_<SolverReport>(m, "SolverReport", "What a continuous solver did.")
      .def_readonly("status", &SolverReport::status)
      .def_readonly("iterations", &SolverReport::iterations, "Linear systems solved.")
      .def_readonly("costs", &SolverReport::costs, "At the start and after each accepted step.")
      .def_readonly("seconds", &SolverReport::seconds)
      .def_readonly("message", &SolverReport::message)
      .def_readonly("under_constrained", &SolverReport::under_constrained,
                    "Variables that the factors do not determine.");
  py::class_<SolverResult>(m, "SolverResult", "What a continuous solver found.")
      .def_readonly("values", &SolverResult::values)
      .def_readonly("report", &SolverResult::report);
  py::class_<HalfStep>(m, "HalfStep", "The joint objective after a half-step.")
      .def_readonly("discrete", &HalfStep::discrete)
      .def_readonly("objective", &HalfStep::objective)
      .def_readonly("changes", &HalfStep::changes, "Variables that changed value, or iterations.");
  py::class_<AlternatingReport>(m, "AlternatingReport", "What the alternation did.")
      .def_readonly("status", &AlternatingReport::status)
      .def_readonly("iterations", &AlternatingReport::iterations, "Pairs of half-steps.")
      .def_readonly("initial_objective", &AlternatingReport::initial_objective)
      .def_readonly("objective", &AlternatingReport::objective, "Of eq. 6.")
      .def_readonly("cost", &AlternatingReport::cost, "Half the weighted squared error.")
      .def_readonly("half_steps", &AlternatingReport::half_steps, "Never rising (eq. 10).")
      .def_readonly("discrete_exact", &AlternatingReport::discrete_exact)
      .def_readonly("last_solve", &AlternatingReport::last_solve)
      .def_readonly("seconds", &AlternatingReport::seconds)
      .def_readonly("message", &AlternatingReport::message);
  py::class_<AlternatingResult>(m, "AlternatingResult", "What the alternation found.")
      .def_readonly("estimate", &AlternatingResult::estimate)
      .def_readonly("report", &AlternatingResult::report);
  py::class_<ExhaustiveResult>(m, "ExhaustiveResult", "The best of all assignments.")
      .def_readonly("estimate", &ExhaustiveResult::estimate)
      .def_readonly("objective", &ExhaustiveResult::objective)
      .def_readonly("keys", &ExhaustiveResult::keys)
      .def_readonly("objectives", &ExhaustiveResult::objectives,
                    "By joint value of `keys`, the first varying slowest.");
  py::class_<FreeVariable>(m, "FreeVariable", "A variable that the factors do not determine.")
      .def_readonly("key", &FreeVariable::key)
      .def_readonly("directions", &FreeVariable::directions,
                    "Basis (dim, k) of where it can move, in its tangent.");
}

void bind_certificate(py::module_& m) {
  py::class_<Certificate>(m, "Certificate", "What is proven of an estimate of a pose graph.")
      .def_readonly("verified", &Certificate::verified,
                    "No other poses cost less, but for `relative_gap`.")
      .def_readonly("min_eigenvalue", &Certificate::min_eigenvalue)
      .def_readonly("relative_gap", &Certificate::relative_gap)
      .def_readonly("cost", &Certificate::cost, "Of the isotropic problem.")
      .def_readonly("message", &Certificate::message, "Where nothing could be computed.");
  m.def(
      "certify",
      [](const std::vector<FactorArgument>& factors, const Values& estimate) {
        const std::vector<ContinuousFactorPtr> pointers = to_pointers(factors);
        const py::gil_scoped_release unlocked;
        return certify(pointers, estimate);
      },
      "factors"_a, "estimate"_a,
      "Whether an estimate lies in the basin of the global optimum of its relative poses, by the "
      "dual certificate of SE-Sync.");
}

}  // namespace

void bind_solvers(py::module_& m) {
  bind_options(m);
  bind_reports(m);
  bind_certificate(m);
  m.def(
      "alternate",
      [](const HybridGraph& graph, const Estimate& initial, const AlternatingOptions& options) {
        return alternate(graph, initial, options);
      },
      "graph"_a, "initial"_a, "options"_a = AlternatingOptions(), Unlocked(),
      "Alternating minimisation of the joint objective (eq. 8-10): the exact discrete half-step, "
      "then Levenberg-Marquardt, until neither changes anything.");
  m.def("levenberg_marquardt",
        py::overload_cast<const HybridGraph&, const Estimate&, const SolverOptions&>(
            &levenberg_marquardt),
        "graph"_a, "initial"_a, "options"_a = SolverOptions(), Unlocked(),
        "Minimises the continuous variables for a fixed assignment (eq. 8b).");
  m.def("dogleg",
        py::overload_cast<const HybridGraph&, const Estimate&, const SolverOptions&>(&dogleg),
        "graph"_a, "initial"_a, "options"_a = SolverOptions(), Unlocked(),
        "The same by Powell's dogleg.");
  m.def(
      "solve_exhaustive",
      py::overload_cast<const HybridGraph&, const Values&, const SolverOptions&>(&solve_exhaustive),
      "graph"_a, "initial"_a, "options"_a = SolverOptions(), Unlocked(),
      "The joint minimum by trying every assignment, for small graphs.");
  m.def(
      "chordal_initialization",
      [](const std::vector<FactorArgument>& factors, const Values& initial) {
        const std::vector<ContinuousFactorPtr> pointers = to_pointers(factors);
        const py::gil_scoped_release unlocked;
        return chordal_initialization(pointers, initial);
      },
      "factors"_a, "initial"_a,
      "A start from all relative poses among the factors, by two linear problems; poses with a "
      "prior stay at their initial values, or else the first one.");
  m.def(
      "free_variables",
      [](const HybridGraph& graph, const Estimate& estimate) {
        return free_variables(graph, estimate);
      },
      "graph"_a, "estimate"_a, Unlocked(),
      "The variables that the factors do not determine at an estimate.");
}

}  // namespace hybrid::python
