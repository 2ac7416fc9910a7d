// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <cstring>

#include "libhybrid/io/read_points.h"
#include "libhybrid/registration/register.h"
#include "python/fields.h"

namespace hybrid::python {

static_assert(sizeof(Eigen::Vector3d) == 3 * sizeof(double));

std::vector<Eigen::Vector3d> to_points(const PointArray& array) {
  if (array.ndim() != 2 || array.shape(1) != 3) {
    throw Error("a cloud is an array of n x 3 numbers, one point a row, not of shape " +
                py::str(array.attr("shape")).cast<std::string>());
  }
  std::vector<Eigen::Vector3d> points(static_cast<std::size_t>(array.shape(0)));
  if (!points.empty()) {
    std::memcpy(points.front().data(), array.data(), sizeof(Eigen::Vector3d) * points.size());
  }
  return points;
}

PointArray to_array(const std::vector<Eigen::Vector3d>& points) {
  PointArray array(std::vector<py::ssize_t>{static_cast<py::ssize_t>(points.size()), 3});
  if (!points.empty()) {
    std::memcpy(array.mutable_data(), points.front().data(),
                sizeof(Eigen::Vector3d) * points.size());
  }
  return array;
}

namespace {

void bind_result(py::module_& m) {
  using Result = RegistrationResult;
  py::enum_<Result::Status>(m, "RegistrationStatus", "How a registration ended.")
      .value("CONVERGED", Result::Status::kConverged)
      .value("UNOBSERVABLE", Result::Status::kUnobservable)
      .value("NO_MATCH", Result::Status::kNoMatch);
  FieldsClass<FreeMotion>(m, "FreeMotion",
                          "A motion of the source that the matches do not determine.")
      .def_readonly("is_rotation", &FreeMotion::is_rotation)
      .def_readonly("direction", &FreeMotion::direction, "(3,), of unit norm.")
      .def_readonly("through", &FreeMotion::through, "A point (3,) on the axis of a rotation.")
      .def("__str__", [](const FreeMotion& motion) { return to_string(motion); });
  FieldsClass<Result>(m, "RegistrationResult", "The result of a registration.")
      .kept("assignment", &Result::assignment)
      .def_readonly("status", &Result::status)
      .def_readonly("T_target_source", &Result::T_target_source)
      .def_readonly("covariance", &Result::covariance,
                    "Tangent covariance (6, 6), if all motions are observable.")
      .def_readonly("free_motions", &Result::free_motions)
      .def_property_readonly(
          "assignment",
          [](const Result& result) {
            return py::array_t<int>(result.assignment.size(), result.assignment.data());
          },
          "Index (n,) of the corresponding target point of each source point, -1 for none.")
      .def_readonly("inliers", &Result::inliers)
      .def_readonly("rms", &Result::rms, "RMS distance between matched points.")
      .def_readonly("rms_across", &Result::rms_across, "Its part across the surface or curve.")
      .def_readonly("objective", &Result::objective)
      .def_readonly("iterations", &Result::iterations, "Pairs of half-steps.")
      .def_readonly("starts", &Result::starts, "Number of starts tried.")
      .def_readonly("seconds", &Result::seconds);
}

}  // namespace

void bind_registration(py::module_& m) {
  py::enum_<MatchMetric>(m, "MatchMetric", "The distance that a match measures.")
      .value("SURFACE", MatchMetric::kSurface)
      .value("POINT", MatchMetric::kPoint);
  SettingsClass<RegistrationOptions>(m, "RegistrationOptions", "Settings of `register_clouds`.")
      .field("start", &RegistrationOptions::start, "Initial T_target_source.")
      .field("metric", &RegistrationOptions::metric,
             "Distance to the surface or to the point of a match.")
      .field("gate", &RegistrationOptions::gate, "Gate of matches in standard deviations.")
      .field("convincing_share", &RegistrationOptions::convincing_share,
             "If a smaller share of points is matched from the start, other starts are tried too.")
      .field("threads", &RegistrationOptions::threads,
             "Number of threads; 0: one per core, at most 4.");
  bind_result(m);
  m.def(
      "register_clouds",
      [](const PointArray& source, const PointArray& target, const RegistrationOptions& options) {
        const std::vector<Eigen::Vector3d> from = to_points(source), to = to_points(target);
        const py::gil_scoped_release unlocked;
        return register_clouds(from, to, options);
      },
      "source"_a, "target"_a, "options"_a = RegistrationOptions(),
      "Estimates the rigid motion from source (n, 3) to target (m, 3), and corresponding points.");
  m.def(
      "read_points", [](const std::string& path) { return to_array(read_points(path).points); },
      "path"_a, "The points (n, 3) of a .ply, .pcd, .xyz, .txt, .asc or .csv file.");
}

}  // namespace hybrid::python
