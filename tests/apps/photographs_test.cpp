// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// The images of a log in its report.
#include <gtest/gtest.h>
#include <mrpt/core/Clock.h>
#include <mrpt/obs/CObservationImage.h>
#include <zlib.h>

#include <array>
#include <cmath>
#include <string>

#include "tests/apps/replay_runner.h"
#include "tests/mrpt_plugins/input/log_files.h"

namespace hybrid {
namespace {

class ReportTest : public ReplayTest {
 protected:
  /// A robot that drives 1 m at a time towards landmark 5, 10 m ahead and 1 m to the left.
  std::string log(bool with_images) const {
    Objects objects;
    for (int k = 0; k < 6; ++k) {
      auto frame = mrpt::obs::CSensoryFrame::Create();
      auto seen = mrpt::obs::CObservationBearingRange::Create();
      seen->timestamp = mrpt::Clock::fromDouble(1000 + k);
      seen->sensor_std_range = 0.01F;
      seen->sensor_std_yaw = 0.01F;
      seen->sensedData.resize(1);
      seen->sensedData[0].range = static_cast<float>(std::hypot(10 - k, 1));
      seen->sensedData[0].yaw = static_cast<float>(std::atan2(1, 10 - k));
      seen->sensedData[0].landmarkID = 5;
      frame->insert(seen);
      if (with_images && k % 2 == 0) frame->insert(image(seen->timestamp));
      if (k > 0) objects.push_back(std::make_shared<mrpt::obs::CActionCollection>(step()));
      objects.push_back(frame);
    }
    const std::string path = at(with_images ? "images.rawlog" : "plain.rawlog");
    write_log(path, objects);
    return path;
  }

  static mrpt::obs::CActionCollection step() {
    auto pdf = mrpt::poses::CPosePDFGaussian::Create();
    pdf->mean = mrpt::poses::CPose2D(1, 0, 0);
    pdf->cov.setDiagonal(3, 1e-4);
    mrpt::obs::CActionRobotMovement2D action;
    action.estimationMethod = mrpt::obs::CActionRobotMovement2D::emScan2DMatching;
    action.poseChange = pdf;
    return mrpt::obs::CActionCollection(action);
  }

  static mrpt::obs::CObservationImage::Ptr image(mrpt::system::TTimeStamp stamp) {
    auto out = mrpt::obs::CObservationImage::Create();
    out->timestamp = stamp;
    out->sensorLabel = "front";
    out->image = mrpt::img::CImage(64, 48, mrpt::img::CH_RGB);
    for (int y = 0; y < 48; ++y) {
      for (int x = 0; x < 64 * 3; ++x) out->image.ptr<std::uint8_t>(0, y)[x] = 128;
    }
    out->cameraParams.ncols = 64;
    out->cameraParams.nrows = 48;
    out->cameraParams.setIntrinsicParamsFromValues(50, 50, 32, 24);
    return out;
  }

  /// The data of out/report.html.
  nlohmann::json data() const {
    const std::string page = read("out/report.html"), mark = "id=\"data\">";
    const std::size_t from = page.find(mark) + mark.size();
    const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string packed;
    unsigned bits = 0, held = 0;
    for (std::size_t i = from; digits.find(page[i]) != std::string::npos; ++i) {
      held = held << 6 | static_cast<unsigned>(digits.find(page[i]));
      bits += 6;
      if (bits < 8) continue;
      bits -= 8;
      packed.push_back(static_cast<char>(held >> bits & 0xff));
    }
    write("data.gz", packed);
    gzFile file = gzopen(at("data.gz").c_str(), "rb");
    std::string text;
    std::array<char, 65536> buffer{};
    for (int got = 1; got > 0;) {
      got = gzread(file, buffer.data(), buffer.size());
      if (got > 0) text.append(buffer.data(), static_cast<std::size_t>(got));
    }
    gzclose(file);
    return nlohmann::json::parse(text);
  }
};

TEST_F(ReportTest, HoldsThePhotographsOfTheLogAndChangesNothingElse) {
  summary_of("--report " + log(true));
  const nlohmann::json photographs = data().at("photographs");
  EXPECT_EQ(photographs["unreadable"], 0);
  ASSERT_EQ(photographs["list"].size(), 3U);
  for (int i = 0; i < 3; ++i) {
    const nlohmann::json& one = photographs["list"][i];
    EXPECT_EQ(one["k"], 2 * i);
    EXPECT_EQ(one["sensor"], "front");
    EXPECT_EQ(one["camera"]["f"], (std::vector<double>{50, 50}));
    EXPECT_GT(one["jpeg"].get<std::string>().size(), 100U);
  }
  const std::string path = read("out/trajectory.tum");
  summary_of("--report " + log(false));
  EXPECT_EQ(data().at("photographs")["list"].size(), 0U);
  EXPECT_EQ(read("out/trajectory.tum"), path);
}

}  // namespace
}  // namespace hybrid
