// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/byte_io.h"

namespace hybrid {

void write_points(ByteWriter& out, const std::vector<mrpt::math::TPoint3Df>& points) {
  out.put(static_cast<std::uint32_t>(points.size()));
  for (const auto& p : points) put_all(out, p.x, p.y, p.z);
}

std::vector<mrpt::math::TPoint3Df> read_points(ByteReader& in) {
  std::vector<mrpt::math::TPoint3Df> points(in.count(3 * sizeof(float)));
  for (auto& p : points) get_all(in, p.x, p.y, p.z);
  return points;
}

void write_time(ByteWriter& out, mrpt::system::TTimeStamp time) {
  out.put<std::int64_t>(time.time_since_epoch().count());
}

mrpt::system::TTimeStamp read_time(ByteReader& in) {
  using Time = mrpt::system::TTimeStamp;
  return Time(Time::duration(in.get<std::int64_t>()));
}

void write_pose(ByteWriter& out, const mrpt::poses::CPose3D& pose) {
  put_all<double, double, double>(out, pose.x(), pose.y(), pose.z());
  write_matrix(out, pose.getRotationMatrix());
}

mrpt::poses::CPose3D read_pose_3d(ByteReader& in) {
  double x = 0, y = 0, z = 0;
  get_all(in, x, y, z);
  mrpt::math::CMatrixDouble33 R;
  read_matrix(in, R);
  mrpt::poses::CPose3D pose(x, y, z);
  pose.setRotationMatrix(R);
  return pose;
}

void write_pose(ByteWriter& out, const mrpt::poses::CPose2D& pose) {
  put_all<double, double, double>(out, pose.x(), pose.y(), pose.phi());
}

mrpt::poses::CPose2D read_pose_2d(ByteReader& in) {
  double x = 0, y = 0, phi = 0;
  get_all(in, x, y, phi);
  mrpt::poses::CPose2D pose(x, y, 0);
  pose.phi(phi);  // the constructor would round it
  return pose;
}

}  // namespace hybrid
