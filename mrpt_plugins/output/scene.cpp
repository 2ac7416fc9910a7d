// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/scene.h"

#include <mrpt/serialization/CArchive.h>

#include <Eigen/Eigenvalues>
#include <map>

#include "mrpt_plugins/bridge/gzip_writer.h"
#include "mrpt_plugins/mrpt_version.h"
#include "mrpt_plugins/output/map_style.h"
#include "mrpt_plugins/output/mesh.h"
#include "mrpt_plugins/output/scene_layout.h"
#include HYBRID_MRPT_SCENE(CGridPlaneXY)
#include HYBRID_MRPT_SCENE(CText)
#include HYBRID_MRPT_SCENE(stock_objects)

namespace hybrid {
namespace {

using Eigen::Vector3d;

constexpr int kCompression = 1;  // level of MRPT's own scene files
constexpr Color kStem{150, 150, 150};

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
void add_paths(Mesh& mesh, const MapResult& result, const GroundTruth& truth, double r) {
  mesh.set_color(palette::kTruth);
  for (const Trajectory& known : true_paths(truth)) {
    for (const auto& bead : dashes(positions(known), 2.5 * r, 13 * r)) mesh.tube(bead, 1.8 * r);
  }
  mesh.set_color(palette::kDeadReckoning);
  if (result.robots.empty()) {
    for (const auto& dash : dashes(positions(result.dead_reckoning), 9 * r, 6 * r)) {
      mesh.tube(dash, 0.6 * r);
    }
  }
  for (const DrawnPath& robot : drawn_paths(result)) {
    mesh.set_color(robot.stroke.color);
    mesh.tube(positions(robot.poses), r);
    if (robot.poses.empty()) continue;
    mesh.set_color(palette::kWhite);
    mesh.marker(positions(robot.poses).front(), Marker::kTriangle, 4 * r);
    mesh.set_color(palette::kInk);
    mesh.marker(positions(robot.poses).back(), Marker::kSquare, 3.2 * r);
  }
}

/// What laser scans saw, as low walls as far as the ground reaches: a block for each row of cells.
void add_walls(Mesh& mesh, const GridMap& grid, const SceneLayout& layout) {
  mesh.set_color(map_style::kWall);
  const Eigen::Array3d ground_low = layout.ground.low, ground_high = layout.ground.high;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width;) {
      const int from = x;
      while (x < grid.width && grid.at(x, y) == GridMap::kOccupied) ++x;
      const Vector3d low(grid.corner.x() + from * grid.resolution,
                         grid.corner.y() + y * grid.resolution, 0);
      const Vector3d high(grid.corner.x() + x * grid.resolution, low.y() + grid.resolution,
                          layout.wall_height);
      const bool is_shown = (low.array() >= ground_low).head<2>().all() &&
                            (high.array() <= ground_high).head<2>().all();
      if (x > from && is_shown) mesh.block(low, high);
      if (x == from) ++x;
    }
  }
}

void add_landmarks(Mesh& mesh, const MapResult& result, const GroundTruth& truth,
                   const SceneLayout& layout) {
  mesh.set_color(map_style::kTrueLandmark);
  for (const TrueLandmark& l : truth.landmarks) {
    mesh.marker(l.position, Marker::kPlus, 2 * layout.landmark_radius);
  }
  const Vector3d toward = (layout.view.eye() - layout.view.target).normalized();
  for (const LandmarkEstimate& l : result.landmarks) {
    if (!l.position.allFinite()) continue;
    mesh.set_color(landmark_fill(l));
    mesh.marker(l.position, landmark_marker(l), layout.landmark_radius, toward);
    if (!result.is_3d) continue;
    mesh.set_color(kStem);
    mesh.tube({{l.position.x(), l.position.y(), layout.ground.low.z()}, l.position},
              0.0004 * layout.view.distance);
  }
}

/// Adds ellipsoids, those that are far away first: what is added later would be hidden by them.
void add_ellipsoids(Mesh& mesh, const MapResult& result, const SceneLayout& layout) {
  std::multimap<double, const LandmarkEstimate*> by_nearness;
  for (const LandmarkEstimate& l : result.landmarks) {
    if (!l.position.allFinite() || !l.covariance.allFinite() || !(l.covariance.trace() > 0)) {
      continue;
    }
    by_nearness.emplace(-(layout.view.eye() - l.position).norm(), &l);
  }
  for (const auto& [nearness, l] : by_nearness) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(l->covariance);
    const Vector3d half_axes = (map_style::kSigmas * layout.frame.magnification *
                                eigen.eigenvalues().cwiseMax(0).cwiseSqrt())
                                   .cwiseMax(0.05 * layout.landmark_radius);
    mesh.set_color(landmark_color(*l), 0.3);
    mesh.ellipsoid(l->position, eigen.eigenvectors() * half_axes.asDiagonal());
  }
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
  Mesh mesh;
  if (result.grid) add_walls(mesh, *result.grid, layout);
  add_paths(mesh, result, truth, layout.path_radius);
  add_landmarks(mesh, result, truth, layout);
  add_ellipsoids(mesh, result, layout);
  scene->insert(mesh.object());
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
