// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/scene.h"

#include <mrpt/serialization/CArchive.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <map>

#include "mrpt_plugins/bridge/gzip_writer.h"
#include "mrpt_plugins/mrpt_version.h"
#include "mrpt_plugins/output/map_style.h"
#include "mrpt_plugins/output/mesh.h"
#include "mrpt_plugins/output/scene_layout.h"
#include HYBRID_MRPT_SCENE(CGridPlaneXY)
#include HYBRID_MRPT_SCENE(CSetOfLines)
#include HYBRID_MRPT_SCENE(CText)
#include HYBRID_MRPT_SCENE(stock_objects)

namespace hybrid {
namespace {

using Eigen::Vector3d;

constexpr int kCompression = 1;  // level of MRPT's own scene files

std::vector<Vector3d> positions(const Trajectory& path) {
  std::vector<Vector3d> out;
  for (const TimedPose& p : path) out.emplace_back(p.pose.x(), p.pose.y(), p.pose.z());
  return out;
}

void add_ground(MrptScene& scene, const SceneLayout& layout) {
  const auto& e = layout.ground;
  auto grid = mrpt_scene::CGridPlaneXY::Create(
      static_cast<float>(e.low.x()), static_cast<float>(e.high.x()), static_cast<float>(e.low.y()),
      static_cast<float>(e.high.y()), static_cast<float>(e.low.z()),
      static_cast<float>(layout.grid_step));
  grid->setColor_u8(165, 165, 165);
  scene.insert(grid);
  const auto length = static_cast<float>(layout.axis_length);
  scene.insert(mrpt_scene::stock_objects::CornerXYZSimple(length, 2));
}

/// Truth as beads around the estimate, so that both stay visible.
void add_paths(MrptScene& scene, const MapResult& result, const GroundTruth& truth, double r) {
  Mesh beads(palette::kTruth);
  for (const Trajectory& known : true_paths(truth)) {
    for (const auto& bead : dashes(positions(known), 2.5 * r, 13 * r)) beads.tube(bead, 1.8 * r);
  }
  scene.insert(beads.object());
  Mesh reckoned(palette::kDeadReckoning);
  if (result.robots.empty()) {
    for (const auto& dash : dashes(positions(result.dead_reckoning), 9 * r, 6 * r)) {
      reckoned.tube(dash, 0.6 * r);
    }
  }
  scene.insert(reckoned.object());
  for (const DrawnPath& robot : drawn_paths(result)) {
    Mesh path(robot.stroke.color);
    path.tube(positions(robot.poses), r);
    scene.insert(path.object());
    if (robot.poses.empty()) continue;
    Mesh start(palette::kWhite);
    start.marker(positions(robot.poses).front(), Marker::kTriangle, 4 * r);
    scene.insert(start.object());
    Mesh end(palette::kInk);
    end.marker(positions(robot.poses).back(), Marker::kSquare, 3.2 * r);
    scene.insert(end.object());
  }
}

/// Adds ellipsoids before the solids inside them: a solid added later would be hidden by them.
void add_ellipsoids(MrptScene& scene, const MapResult& result, const SceneLayout& layout) {
  for (const LandmarkEstimate& l : result.landmarks) {
    if (!l.position.allFinite() || !l.covariance.allFinite() || !(l.covariance.trace() > 0)) {
      continue;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(l.covariance);
    const Vector3d half_axes = (map_style::kSigmas * layout.frame.magnification *
                                eigen.eigenvalues().cwiseMax(0).cwiseSqrt())
                                   .cwiseMax(0.05 * layout.landmark_radius);
    Mesh mesh(landmark_color(l), 0.3);
    mesh.ellipsoid(l.position, eigen.eigenvectors() * half_axes.asDiagonal());
    scene.insert(mesh.object());
  }
}

void add_landmarks(MrptScene& scene, const MapResult& result, const GroundTruth& truth,
                   const SceneLayout& layout) {
  Mesh crosses(map_style::kTrueLandmark);
  for (const TrueLandmark& l : truth.landmarks) {
    crosses.marker(l.position, Marker::kPlus, 2 * layout.landmark_radius);
  }
  scene.insert(crosses.object());
  const Vector3d toward = (layout.view.eye() - layout.view.target).normalized();
  std::map<std::array<std::uint8_t, 3>, Mesh> solids;  // by colour
  auto stems = mrpt_scene::CSetOfLines::Create();
  stems->setColor_u8(150, 150, 150);
  for (const LandmarkEstimate& l : result.landmarks) {
    if (!l.position.allFinite()) continue;
    const Color fill = landmark_fill(l);
    const auto mesh = solids.try_emplace({fill.red, fill.green, fill.blue}, fill).first;
    mesh->second.marker(l.position, landmark_marker(l), layout.landmark_radius, toward);
    if (result.is_3d) {
      stems->appendLine(l.position.x(), l.position.y(), layout.ground.low.z(), l.position.x(),
                        l.position.y(), l.position.z());
    }
  }
  scene.insert(stems);
  for (const auto& [color, mesh] : solids) scene.insert(mesh.object());
}

void add_texts(MrptScene& scene, const MapResult& result, const SceneLayout& layout) {
  for (const LandmarkEstimate& l : result.landmarks) {
    if (!l.position.allFinite()) continue;
    std::string text = std::to_string(l.id);
    if (l.class_index)
      text += ' ' + result.class_names.at(static_cast<std::size_t>(*l.class_index));
    auto label = mrpt_scene::CText::Create(text);
    label->setFont("sans", 14);
    label->setColor_u8(40, 40, 40);
    label->setLocation(l.position.x(), l.position.y(),
                       l.position.z() + 1.8 * layout.landmark_radius);
    scene.insert(label);
  }
}

}  // namespace

MrptScene::Ptr make_scene(const MapResult& result, const GroundTruth& truth) {
  const SceneLayout layout = scene_layout(result, truth);
  auto scene = MrptScene::Create();
  auto viewport = scene->getViewport();
  viewport->setCustomBackgroundColor({1, 1, 1, 1});
  const mrpt::math::TVector3Df from_above_and_behind_the_camera(0.1f, 0.64f, -0.76f);
  set_light(viewport->lightParameters(), 0.6f, 0.55f, 0.05f, from_above_and_behind_the_camera);
  add_ground(*scene, layout);
  add_paths(*scene, result, truth, layout.path_radius);
  add_ellipsoids(*scene, result, layout);
  add_landmarks(*scene, result, truth, layout);
  add_texts(*scene, result, layout);
  auto& camera = viewport->getCamera();
  camera.setPointingAt(layout.view.target.x(), layout.view.target.y(), layout.view.target.z());
  camera.setZoomDistance(static_cast<float>(layout.view.distance));
  camera.setAzimuthDegrees(static_cast<float>(layout.view.azimuth_deg));
  camera.setElevationDegrees(static_cast<float>(layout.view.elevation_deg));
  return scene;
}

void save_scene(const OutputDirectory& out, const std::string& name, const MapResult& result,
                const GroundTruth& truth) {
  const auto scene = make_scene(result, truth);
  out.save(name, [&](const std::string& path) {
    GzipWriter file(path, kCompression, out.folder() / name);
    mrpt::serialization::archiveFrom<mrpt::io::CStream>(file) << *scene;
    file.close();
  });
}

}  // namespace hybrid
