// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "apps/command_line.h"
#include "apps/exit_code.h"
#include "apps/program.h"
#include "libhybrid/core/error.h"
#include "libhybrid/geometry/se3.h"
#include "libhybrid/io/text_reader.h"
#include "libhybrid/registration/register.h"
#include "mrpt_plugins/bridge/output_directory.h"
#include "mrpt_plugins/bridge/provenance.h"
#include "mrpt_plugins/input/point_maps.h"
#include "mrpt_plugins/output/overlay_image.h"

namespace hybrid {
namespace {

/// Options of the command line.
struct Options {
  Provenance provenance;  ///< version and command
  std::string source, target;
  std::string metric = "surface";
  std::string start;  ///< file with a 4x4 matrix; empty: the identity
  bool search = true;
  int threads = 0;
  std::string unit;
  std::string output = "hybrid-register-out";
};

constexpr const char* kAbout =
    "Registers one point cloud to another: finds the rigid motion that takes SOURCE into TARGET,\n"
    "which points correspond, and which have no counterpart.\n";

constexpr const char* kFooter =
    "\nClouds: .xyz .txt .asc .csv (rows x y z), .ply (text or binary), .pcd, MRPT points\n"
    "maps and simple maps, and rawlogs: LOG.rawlog#N is what the scans of step N see.\n"
    "\nWritten to OUT: transform.txt (4x4, source into target), summary.json, overlay.png. They\n"
    "replace the result that OUT holds; files of others stay.\n"
    "\nExit code: 0 all well; 1 failure, nothing written; 2 the clouds leave a motion free (two\n"
    "planes slide, two lines turn), summary.json says which; or less than a tenth of the smaller\n"
    "cloud is matched, status \"partial\". The transform was written. A signal (Ctrl-C) ends it "
    "at\n"
    "once, with nothing written.\n"
    "\nExample: hybrid-register scan2.ply scan1.ply -o out";

/// Parses the command line. Returns nothing, with `exit_code` set, if the program is to end at
/// once, as after --help; the text for the user has then been printed.
std::optional<Options> parse_options(int argc, char** argv, int& exit_code) {
  Options options;
  CLI::App app(kAbout, "hybrid-register");
  app.footer(kFooter);
  app.add_option("source", options.source, "the cloud that moves")->type_name("SOURCE")->required();
  app.add_option("target", options.target, "the cloud that stays")->type_name("TARGET")->required();
  app.add_option("--metric", options.metric,
                 "surface: distance to the surface of the target (point to plane), or to its curve "
                 "where it is a plane scan; point: distance to the point")
      ->type_name("METRIC")
      ->check(CLI::IsMember({"surface", "point"}))
      ->capture_default_str();
  app.add_option("--start", options.start,
                 "file with a 4x4 matrix to start from, as transform.txt; default: the identity")
      ->type_name("FILE");
  app.add_flag("!--no-search", options.search,
               "keep to the start also where less than 80 % of the source finds a counterpart");
  app.add_option("--threads", options.threads, "0: one per core; the result does not depend on it")
      ->type_name("N")
      ->check(CLI::Range(0, 256))
      ->capture_default_str();
  app.add_option("--unit", options.unit, "unit of length for picture and messages, e.g. m")
      ->type_name("UNIT");
  add_output_folder(app, options.output);
  if (!parse_command_line(app, argc, argv, exit_code)) return std::nullopt;
  options.provenance = provenance_of(argc, argv);
  return options;
}

constexpr double kTolerance = 1e-3;  // for rotation matrices typed by hand

/// Reads a 4x4 matrix, row by row. Throws Error for a missing or malformed file, or a matrix that
/// is not a rigid motion.
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

/// The matrix as text of the same form, with all digits.
std::string transform_text(const SE3& T) {
  const Eigen::Matrix4d M = T.matrix();
  std::string text;
  for (int i = 0; i < 4; ++i) {
    fmt::format_to(std::back_inserter(text), "{:.15g} {:.15g} {:.15g} {:.15g}\n", M(i, 0), M(i, 1),
                   M(i, 2), M(i, 3));
  }
  return text;
}

using Json = nlohmann::ordered_json;

Points read_input(const std::string& path) {
  PointFile file = read_point_source(path);
  if (file.left_out > 0) {
    complain("hybrid-register: {}: {} points that are not finite were left out\n", path,
             file.left_out);
  }
  if (file.points.size() < 3) {
    throw Error(fmt::format("{}: holds {} points; a registration needs at least 3", path,
                            file.points.size()));
  }
  return std::move(file.points);
}

const char* shape_name(LocalShape shape) {
  if (shape == LocalShape::kSurface) return "surface";
  return shape == LocalShape::kCurve ? "curve" : "point";
}

std::string free_text(const RegistrationResult& result) {
  std::string text;
  for (const FreeMotion& motion : result.free_motions) {
    text += (text.empty() ? "" : "; ") + to_string(motion);
  }
  return text;
}

constexpr double kFewMatched = 0.1;  ///< share of the smaller cloud; less is no registration

/// What a user should know of a result that may be wrong; empty if it is sound.
std::string concern(const RegistrationResult& result, std::size_t source_points,
                    std::size_t target_points) {
  std::string text;
  if (!result.free_motions.empty()) {
    text = "the matches do not determine: " + free_text(result);
  }
  const auto most = static_cast<double>(std::min(source_points, target_points));
  if (result.inliers < kFewMatched * most) {
    text += fmt::format(
        "{}only {} of {} points of the source are matched, the transform is likely wrong; are both "
        "clouds in the same unit, and do they overlap?",
        text.empty() ? "" : "; ", result.inliers, source_points);
  }
  return text;
}

Json stages_json(const RegistrationResult& result) {
  Json stages = Json::array();
  for (const RegistrationStage& stage : result.stages) {
    stages.push_back({{"source_points", stage.source_points},
                      {"target_points", stage.target_points},
                      {"noise_across", stage.noise.across},
                      {"noise_along", stage.noise.along},
                      {"inliers", stage.inliers},
                      {"objectives", stage.objectives}});
  }
  return stages;
}

Json summary_json(const RegistrationResult& result, const Provenance& provenance,
                  std::size_t source_points, std::size_t target_points) {
  const bool determined = result.free_motions.empty();
  const std::string message = concern(result, source_points, target_points);
  const char* status = message.empty() ? "ok" : "partial";
  Json json = summary_start(determined ? status : "unobservable", message, provenance);
  json["solver_s"] = result.seconds;
  json["iterations"] = result.iterations;
  json["starts"] = result.starts;
  json["rms"] = result.rms;
  json["rms_across"] = result.rms_across;
  json["inlier_fraction"] = result.inliers / static_cast<double>(source_points);
  json["inliers"] = result.inliers;
  json["source_points"] = source_points;
  json["target_points"] = target_points;
  json["objective"] = result.objective;
  json["metric"] = shape_name(result.shape);
  json["noise"] = {{"across", result.noise.across}, {"along", result.noise.along}};
  Json free = Json::array();
  for (const FreeMotion& motion : result.free_motions) free.push_back(to_string(motion));
  json["unobservable"] = free;
  // Tangent covariance of the transform: translation, then rotation vector [rad], in the axes of
  // the source.
  json["covariance"] = nullptr;
  if (determined) {
    Json rows = Json::array();
    for (int i = 0; i < 6; ++i) {
      rows.push_back(
          std::vector<double>(result.covariance.col(i).begin(), result.covariance.col(i).end()));
    }
    json["covariance"] = rows;
  }
  json["stages"] = stages_json(result);
  return json;
}

double angle_deg(const SE3& T) {
  return T.rotation().log().norm() * 180.0 / M_PI;
}

Overlay overlay_of(const Options& options, const RegistrationResult& result, const SE3& start,
                   Points source, Points target) {
  const auto name = [](const std::string& path) {
    return std::filesystem::path(path).filename().string();
  };
  Overlay overlay;
  overlay.title =
      fmt::format("Registration of {} to {}", name(options.source), name(options.target));
  const std::string unit = options.unit.empty() ? "" : " " + options.unit;
  overlay.note = fmt::format(
      "Turned by {:.4g} degrees, moved by {:.4g}{}; {:.1f} % of the source matched, rms {:.3g}{}",
      angle_deg(result.T_target_source), result.T_target_source.translation().norm(), unit,
      100.0 * result.inliers / static_cast<double>(source.size()), result.rms, unit);
  overlay.source = std::move(source);
  overlay.target = std::move(target);
  overlay.before = start;
  overlay.after = result.T_target_source;
  overlay.unit = options.unit.empty() ? "unit of the files" : options.unit;
  return overlay;
}

Provenance provenance(const Options& options) {
  Provenance provenance = options.provenance;
  for (const std::string& path : {options.source, options.target, options.start}) {
    // LOG.rawlog#N names a step of LOG.rawlog.
    provenance.add_input(std::filesystem::exists(path) ? path : path.substr(0, path.rfind('#')));
  }
  warn_of_inputs(provenance);
  return provenance;
}

/// Reads both clouds, registers them, writes the results and prints a summary. Returns the exit
/// code. Throws on failure.
int run(const Options& options) {
  RegistrationOptions settings;
  settings.metric = options.metric == "point" ? MatchMetric::kPoint : MatchMetric::kSurface;
  settings.threads = options.threads;
  if (!options.search) settings.convincing_share = 0.0;
  if (!options.start.empty()) settings.start = read_transform(options.start);
  Points source = read_input(options.source), target = read_input(options.target);
  const RegistrationResult result = about({options.source + " onto " + options.target}, [&] {
    return register_clouds(source, target, settings);
  });
  if (result.status == RegistrationResult::Status::kNoMatch) {
    throw Error(fmt::format(
        "no counterparts found: {} and {} do not overlap, or the start is too far away; give a "
        "better one with --start",
        options.source, options.target));
  }
  OutputDirectory out(options.output);
  Json summary = summary_json(result, provenance(options), source.size(), target.size());
  const std::string message = concern(result, source.size(), target.size());
  const std::string told =
      fmt::format("{} of {} points matched, rms {:.6g}, turned by {:.6g} degrees, {:.3f} s -> {}\n",
                  result.inliers, source.size(), result.rms, angle_deg(result.T_target_source),
                  result.seconds, out.folder().string());
  out.write("transform.txt", transform_text(result.T_target_source));
  const Overlay overlay =
      overlay_of(options, result, settings.start, std::move(source), std::move(target));
  out.write("overlay.png", png(overlay_image(overlay)));
  const std::vector<std::string> moved = out.publish(std::move(summary));
  const int code = settle(message.empty() ? kExitOk : kExitPartial);
  for (const std::string& text : moved) complain("hybrid-register: {}\n", text);
  say("{}", told);
  if (code != kExitOk) complain("hybrid-register: {}\n", message);
  return code;
}

}  // namespace
}  // namespace hybrid

int main(int argc, char** argv) {
  return hybrid::run_program("hybrid-register", [&] {
    int exit_code = hybrid::kExitOk;
    const auto options = hybrid::parse_options(argc, argv, exit_code);
    return options ? hybrid::run(*options) : exit_code;
  });
}
