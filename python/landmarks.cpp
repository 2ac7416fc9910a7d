// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/geometry/isometry.h"
#include "libhybrid/landmarks/landmark_mapper.h"
#include "python/bindings.h"

namespace hybrid::python {
namespace {

void bind_options(py::module_& m) {
  using Options = AssociationOptions;
  py::enum_<Options::Method>(m, "AssociationMethod")
      .value("HYPOTHESES", Options::Method::kHypotheses)
      .value("NEAREST", Options::Method::kNearest)
      .value("JCBB", Options::Method::kJcbb);
  SettingsClass<Options>(m, "AssociationOptions", "How detections without an id find landmarks.")
      .field("method", &Options::method, "How a frame is matched.")
      .field("use_ids", &Options::use_ids, "Take ids that detections have for granted.")
      .field("gate", &Options::gate, "Chi-square probability of an innovation.")
      .field("information_penalty", &Options::information_penalty, "Of a match, per nat.")
      .field("hypotheses", &Options::hypotheses, "At most, per frame.")
      .field("open_odds", &Options::open_odds, "Hypotheses less probable by this are not kept.")
      .field("window", &Options::window, "Keyframes until an open decision is taken.")
      .field("landmarks_in_view", &Options::landmarks_in_view, "Expected in the field of view.")
      .field("clutter_in_view", &Options::clutter_in_view, "Spurious detections per frame.")
      .field("detection_probability", &Options::detection_probability, "Of a landmark in view.")
      .field("confirm", &Options::confirm, "Sightings that make a landmark.")
      .field("merge", &Options::merge, "Find landmarks that are one, and close loops.")
      .field("recent", &Options::recent, "Keyframes: landmarks that may be merged into others.")
      .field("merge_odds", &Options::merge_odds, "Evidence that a merge needs.");
  SettingsClass<ClassOptions>(m, "ClassOptions", "What is known beforehand of classes.")
      .field("names", &ClassOptions::names, "Empty: as the detections name them.")
      .field("prior", &ClassOptions::prior, "Of a landmark not seen yet; empty: all equal.")
      .field("confusion", &ClassOptions::confusion,
             "p(detected | true), row by row; empty: scores are calibrated.")
      .field("floor", &ClassOptions::floor, "Share of detections that are guesses.");
}

void bind_detections(py::module_& m) {
  SettingsClass<Detection>(m, "Detection", "One thing that a sensor sees in one frame.")
      .field("range", &Detection::range, "[m].")
      .field("yaw", &Detection::yaw, "[rad].")
      .field("pitch", &Detection::pitch, "[rad], positive down; 0 for a planar sensor.")
      .field("id", &Detection::id, "Landmark, if the sensor identifies it.")
      .field("true_id", &Detection::true_id, "For evaluation only.")
      .field("class_probabilities", &Detection::class_probabilities,
             "As long as class_names of the frame, or empty.")
      .field("covariance", &Detection::covariance, "(3, 3) of range, yaw, pitch.")
      .field("moving", &Detection::moving, "It was not at rest: no landmark.");
  using Frame = DetectionFrame;
  SettingsClass<Frame> frame(m, "DetectionFrame", "What one sensor saw at one time.");
  frame.field("time", &Frame::time, "[s since 1970].")
      .field("sensor_label", &Frame::sensor_label, "Its name.")
      .field("is_3d", &Frame::is_3d, "Whether pitch is measured.")
      .field("has_range", &Frame::has_range, "False for a sensor of directions only.")
      .field("min_range", &Frame::min_range, "[m].")
      .field("max_range", &Frame::max_range, "[m]; 0: no limit.")
      .field("fov_yaw", &Frame::fov_yaw, "Full angle [rad].")
      .field("fov_pitch", &Frame::fov_pitch, "Full angle [rad].")
      .field("class_names", &Frame::class_names, "Of class_probabilities.")
      .field("detections", &Frame::detections, "A copy: assign the list, do not append to it.");
  frame.def_property(
      "T_robot_sensor",
      [](const Frame& f) {
        return SE3(Eigen::Vector3d(f.T_robot_sensor.translation()),
                   Eigen::Quaterniond(f.T_robot_sensor.linear()));
      },
      [](Frame& f, const SE3& T) { f.T_robot_sensor = to_isometry(T); }, "Where the sensor is.");
}

void bind_results(py::module_& m) {
  py::class_<Landmark>(m, "Landmark", "A landmark of the map.")
      .def_readonly("id", &Landmark::id)
      .def_readonly("position", &Landmark::position, "Key of a point (2,) or (3,) [m].")
      .def_readonly("class_key", &Landmark::class_key, "None where it has no class.")
      .def_readonly("sightings", &Landmark::sightings);
  py::class_<AssociationDecision>(m, "AssociationDecision", "What a detection was attributed to.")
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
      .def("add", &Mapper::add, "motion"_a, "noise"_a, "detections"_a, Unlocked(),
           "Adds a keyframe: the measured motion since the one before (the start, for the first), "
           "and what the sensors see. Whether the detections could be used.")
      .def("finish", &Mapper::finish, Unlocked(),
           "Decides what is open, gives up what was seen too rarely, and converges.")
      .def_static("pose_key", &Mapper::pose_key, "i"_a, "The key of a keyframe, from 0.")
      .def_property_readonly("keyframes", &Mapper::keyframes)
      .def_property_readonly("landmarks",
                             [](const Mapper& mapper) {
                               std::vector<Landmark> all;
                               for (const auto& [id, landmark] : mapper.landmarks()) {
                                 all.push_back(landmark);
                               }
                               return all;
                             })
      .def_property_readonly("smoother", &Mapper::smoother,
                             py::return_value_policy::reference_internal,
                             "The map; add to the mapper, not to the smoother.")
      .def("decisions", &Mapper::decisions, "What became of every detection so far.")
      .def_property_readonly(
          "class_names", [](const Mapper& mapper) { return mapper.association().class_names(); })
      .def(
          "statistics", [](const Mapper& mapper) { return mapper.association().statistics(); },
          "Counts of what was done, by name.");
}

}  // namespace

void bind_landmarks(py::module_& m) {
  bind_options(m);
  bind_detections(m);
  bind_results(m);
  bind_mapper<SE2>(m, "LandmarkMapper2",
                   "Maps landmarks in the plane from odometry and detections that nobody has "
                   "identified.");
  bind_mapper<SE3>(m, "LandmarkMapper3", "The same in space.");
}

}  // namespace hybrid::python
