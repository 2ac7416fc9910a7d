// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Data sets of others: the first byte chooses the format; lines "=== NAME" begin its files.

#include <algorithm>

#include "mrpt_plugins/import/carmen.h"
#include "mrpt_plugins/import/detection_tables.h"
#include "mrpt_plugins/import/kitti.h"
#include "mrpt_plugins/import/kitti_tracking.h"
#include "mrpt_plugins/import/mrclam.h"
#include "mrpt_plugins/import/plaza.h"
#include "mrpt_plugins/import/stata.h"
#include "mrpt_plugins/import/victoria_park.h"
#include "tests/fuzz/targets/fuzz_input.h"

using namespace hybrid;

namespace {

constexpr const char* kNames[] = {"odometry.csv",
                                  "detections.csv",
                                  "fixes.csv",
                                  "odometry.g2o",
                                  "poses.txt",
                                  "covariances.txt",
                                  "boxes.txt",
                                  "labels.txt",
                                  "Barcodes.dat",
                                  "Landmark_Groundtruth.dat",
                                  "Robot1_Odometry.dat",
                                  "Robot1_Groundtruth.dat",
                                  "Robot1_Measurement.dat",
                                  "graph.fg",
                                  "known.fg",
                                  "frames.txt",
                                  "detections.txt",
                                  "odometry.txt",
                                  "scan_times.txt",
                                  "tree_detections.txt",
                                  "gps.txt",
                                  "victoria_park_known_assoc_gtsam.txt",
                                  "log.clf"};

/// Writes the files of the input that have a name which a format reads; the others are removed.
void write_files(const fuzz::Folder& folder, std::string_view text) {
  for (const char* name : kNames) std::filesystem::remove(folder.at(name));
  constexpr std::string_view kMark = "=== ";
  while (!text.empty()) {
    const std::size_t begin = text.find(kMark);
    if (begin == std::string_view::npos) return;
    text.remove_prefix(begin + kMark.size());
    const std::size_t end = std::min(text.find(kMark), text.size());
    const std::size_t line = std::min(text.find('\n'), end);
    const std::string_view name = text.substr(0, line);
    if (std::find(std::begin(kNames), std::end(kNames), name) != std::end(kNames)) {
      folder.write(std::string(name), text.substr(line, end - line));
    }
    text.remove_prefix(end);
  }
}

ImportReport import_as(std::size_t format, const fuzz::Folder& folder, const std::string& log) {
  const std::string path = std::filesystem::path(log).parent_path().string();
  if (format == 0) {
    DetectionTablesOptions options;
    options.odometry = folder.at("odometry.csv");
    options.detections = folder.at("detections.csv");
    if (std::filesystem::exists(folder.at("fixes.csv"))) {
      options.fixes.table = folder.at("fixes.csv");
    }
    return import_detection_tables(options, log);
  }
  if (format == 1 || format == 2) {
    KittiOptions options;
    options.odometry = folder.at(format == 1 ? "odometry.g2o" : "poses.txt");
    if (format == 2) options.covariances = folder.at("covariances.txt");
    options.boxes = folder.at("boxes.txt");
    options.truth = folder.at("poses.txt");
    options.oracle_radius = 2;
    return import_kitti(options, log);
  }
  if (format == 3) {
    KittiTrackingOptions options;
    options.labels = folder.at("labels.txt");
    options.poses = folder.at("poses.txt");
    return import_kitti_tracking(options, log);
  }
  if (format == 4) {
    PlazaOptions options;
    options.graph = folder.at("graph.fg");
    options.identities = folder.at("known.fg");
    return import_plaza(options, log);
  }
  if (format == 5) {
    MrclamOptions options;
    options.folder = path;
    return import_mrclam(options, log);
  }
  if (format == 6) {
    StataOptions options;
    options.folder = path;
    options.oracle_radius = 0.4;
    return import_stata(options, log);
  }
  if (format == 7) return import_victoria_park({path}, log);
  CarmenOptions options;
  options.file = folder.at("log.clf");
  return import_carmen(options, log);
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Folder folder;
  fuzz::Input input(data, size);
  const std::size_t format = input.choose(16);
  write_files(folder, input.rest());
  fuzz::allow_error([&] {
    const ImportReport report = import_as(format, folder, folder.at("out.rawlog"));
    fuzz::expect(std::filesystem::exists(folder.at("out.rawlog")));
    fuzz::expect(report.files.front() == folder.at("out.rawlog"));
  });
  return 0;
}
