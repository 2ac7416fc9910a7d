// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/geometry/isometry.h"
#include "libhybrid/landmarks/landmark_mapper.h"
#include "python/calls.h"
#include "python/fields.h"

namespace hybrid::python {
namespace {

void bind_options(py::module_& m) {
  bind_enum(m, "AssociationMethod", AssociationOptions::kMethods);
  SettingsClass<AssociationOptions>(m, "AssociationOptions",
                                    "Settings of the association of detections without ids.")
      .described();
  SettingsClass<ClassOptions>(m, "ClassOptions", "Prior knowledge of classes and of the detector.")
      .described();
}

void bind_detections(py::module_& m) {
  SettingsClass<Detection>(m, "Detection", "One object that a sensor reports in one frame.")
      .field("range", &Detection::range, "[m].")
      .field("yaw", &Detection::yaw, "[rad].")
      .field("pitch", &Detection::pitch, "[rad], positive down; 0 for a planar sensor.")
      .field("id", &Detection::id, "Landmark id, if the sensor identifies landmarks.")
      .field("true_id", &Detection::true_id, "True landmark id, for evaluation only.")
      .field("class_probabilities", &Detection::class_probabilities,
             "Probability of each of the frame's class_names, or empty.")
      .field("covariance", &Detection::covariance, "Covariance (3, 3) of range, yaw, pitch.")
      .field("moving", &Detection::moving, "The object moved, so it is no landmark.");
  using Frame = DetectionFrame;
  SettingsClass<Frame> frame(m, "DetectionFrame", "The detections of one sensor at one time.");
  frame.field("time", &Frame::time, "Time [s] since 1970.")
      .field("sensor_label", &Frame::sensor_label, "Name of the sensor.")
      .field("is_3d", &Frame::is_3d, "Whether pitch is measured.")
      .field("has_range", &Frame::has_range, "False for a sensor that measures directions only.")
      .field("min_range", &Frame::min_range, "[m].")
      .field("max_range", &Frame::max_range, "[m]; 0: no limit.")
      .field("fov_yaw", &Frame::fov_yaw, "Full field of view in yaw [rad].")
      .field("fov_pitch", &Frame::fov_pitch, "Full field of view in pitch [rad].")
      .field("class_names", &Frame::class_names, "Names of the entries of class_probabilities.")
      .field("detections", &Frame::detections, "A copy of the list: assign a list, do not append.");
  frame.def_property(
      "T_robot_sensor",
      [](const Frame& f) {
        return SE3(Eigen::Vector3d(f.T_robot_sensor.translation()),
                   Eigen::Quaterniond(f.T_robot_sensor.linear()));
      },
      [](Frame& f, const SE3& T) { f.T_robot_sensor = to_isometry(T); },
      "Pose of the sensor on the robot.");
}

void bind_results(py::module_& m) {
  FieldsClass<Landmark>(m, "Landmark", "A landmark of the map.")
      .def_readonly("id", &Landmark::id)
      .def_readonly("position", &Landmark::position, "Key of a point (2,) or (3,) [m].")
      .def_readonly("class_key", &Landmark::class_key,
                    "Discrete variable of its class; None without classes.")
      .def_readonly("sightings", &Landmark::sightings);
  FieldsClass<AssociationDecision>(m, "AssociationDecision",
                                   "The landmark that a detection was attributed to.")
      .def_readonly("estimated_id", &AssociationDecision::estimated_id, "None: clutter.")
      .def_readonly("true_id", &AssociationDecision::true_id)
      .def_readonly("pose", &AssociationDecision::pose)
      .def_readonly("measurement", &AssociationDecision::measurement);
}

template <class Pose>
void bind_mapper(py::module_& m, const char* name, const char* doc) {
  using Mapper = LandmarkMapper<Pose>;
  py::class_<Mapper>(m, name, doc)
      .def(py::init([](const AssociationOptions& association, const ClassOptions& classes,
                       const SmootherOptions& smoother) {
             return std::make_unique<Mapper>(LandmarkAssociation(association, ClassModel(classes)),
                                             smoother);
           }),
           "association"_a = AssociationOptions(), "classes"_a = ClassOptions(),
           "smoother"_a = SmootherOptions())
      .def("add", changing(&Mapper::add), "motion"_a, "noise"_a, "detections"_a,
           "Adds a keyframe: the measured motion since the last one (for the first: the start "
           "pose) and the detections of the sensors. Returns whether the detections were used.")
      .def("finish", changing(&Mapper::finish),
           "Makes all delayed decisions, removes landmarks with too few sightings, and solves to "
           "convergence.")
      .def_static("pose_key", &Mapper::pose_key, "i"_a, "The key of a keyframe, from 0.")
      .def_property_readonly("keyframes", looking(+[](const Mapper& m) { return m.keyframes(); }))
      .def_property_readonly("landmarks", looking(+[](const Mapper& mapper) {
                               std::vector<Landmark> all;
                               for (const auto& [id, landmark] : mapper.landmarks()) {
                                 all.push_back(landmark);
                               }
                               return all;
                             }))
      .def_property_readonly("smoother", &Mapper::smoother,
                             py::return_value_policy::reference_internal,
                             "The smoother, to read; add to the mapper, not to the smoother.")
      .def("decisions", reading(&Mapper::decisions), "The attribution of every detection so far.")
      .def_property_readonly(
          "class_names", [](const Mapper& mapper) { return mapper.association().class_names(); })
      .def(
          "statistics", [](const Mapper& mapper) { return mapper.association().statistics(); },
          "Counts of the association, by name.");
}

}  // namespace

void bind_landmarks(py::module_& m) {
  bind_options(m);
  bind_detections(m);
  bind_results(m);
  bind_mapper<SE2>(m, "LandmarkMapper2",
                   "Maps landmarks in 2-D from odometry and detections without ids.");
  bind_mapper<SE3>(m, "LandmarkMapper3",
                   "Maps landmarks in 3-D from odometry and detections without ids.");
}

}  // namespace hybrid::python
