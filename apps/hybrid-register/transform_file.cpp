// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-register/transform_file.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <iterator>

#include "libhybrid/core/error.h"
#include "libhybrid/io/text_reader.h"

namespace hybrid {
namespace {

constexpr double kTolerance = 1e-3;  // for rotation matrices typed by hand

}  // namespace

SE3 read_transform(const std::string& path) {
  TextReader text(path);
  Eigen::Matrix4d M;
  int count = 0;
  while (const auto row = text.next()) {
    for (std::size_t i = 0; i < row->size(); ++i, ++count) {
      if (count == 16) row->fail(i, "more than the 16 numbers of a 4x4 matrix");
      M(count / 4, count % 4) = row->coordinate(i);
    }
  }
  if (count < 16) {
    text.fail(fmt::format("number {} of the 16 of a 4x4 matrix is missing", count + 1));
  }
  const Eigen::Matrix3d R = M.topLeftCorner<3, 3>();
  const bool rigid = M.allFinite() && R.determinant() > 0 &&
                     (R * R.transpose() - Eigen::Matrix3d::Identity()).norm() < kTolerance &&
                     (M.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).norm() < kTolerance;
  if (!rigid)
    throw Error(path + ": is not a rigid motion (rotation, translation, last row 0 0 0 1)");
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d nearest = svd.matrixU() * svd.matrixV().transpose();
  return {M.topRightCorner<3, 1>(), Eigen::Quaterniond(nearest).normalized()};
}

std::string transform_text(const SE3& T) {
  const Eigen::Matrix4d M = T.matrix();
  std::string text;
  for (int i = 0; i < 4; ++i) {
    fmt::format_to(std::back_inserter(text), "{:.15g} {:.15g} {:.15g} {:.15g}\n", M(i, 0), M(i, 1),
                   M(i, 2), M(i, 3));
  }
  return text;
}

}  // namespace hybrid
