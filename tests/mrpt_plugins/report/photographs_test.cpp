// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/report/photographs.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <zlib.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "mrpt_plugins/drawing/mrpt_image.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

using mrpt::obs::CObservationImage;
using Json = nlohmann::ordered_json;

/// A picture of pixels by chance, which JPEG hardly compresses.
mrpt::img::CImage noise(int width, int height, unsigned seed) {
  mrpt::img::CImage image(width, height, mrpt::img::CH_RGB);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < 3; ++c) {
        seed = 1664525U * seed + 1013904223U;
        *image.ptr<std::uint8_t>(x, y, static_cast<std::int8_t>(c)) =
            static_cast<std::uint8_t>(seed >> 24);
      }
    }
  }
  return image;
}

CObservationImage::Ptr observation(const mrpt::img::CImage& image) {
  auto out = CObservationImage::Create();
  out->sensorLabel = "left";
  out->image = image;
  return out;
}

/// The bytes of text in base 64.
std::string bytes_of(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  unsigned bits = 0, held = 0;
  for (const char c : text.substr(0, text.find('='))) {
    held = held << 6 | static_cast<unsigned>(digits.find(c));
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    out.push_back(static_cast<char>(held >> bits & 0xff));
  }
  return out;
}

/// A PNG file of one black bit a pixel.
std::string black_png(std::uint32_t width, std::uint32_t height) {
  const auto word = [](std::uint32_t n) {
    std::string out;
    for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<char>(n >> shift));
    return out;
  };
  const auto chunk = [&](const std::string& content) {  // its name, then its data
    const auto* bytes = reinterpret_cast<const Bytef*>(content.data());
    return word(static_cast<std::uint32_t>(content.size() - 4)) + content +
           word(static_cast<std::uint32_t>(crc32(0, bytes, static_cast<uInt>(content.size()))));
  };
  const std::string rows(std::size_t{(width + 7) / 8 + 1} * height, '\0');
  uLongf size = compressBound(rows.size());
  std::string packed(size, '\0');
  compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
            reinterpret_cast<const Bytef*>(rows.data()), rows.size(), 1);
  packed.resize(size);
  return "\x89PNG\r\n\x1a\n" +
         chunk("IHDR" + word(width) + word(height) + std::string("\1\0\0\0\0", 5)) +
         chunk("IDAT" + packed) + chunk("IEND");
}

using PhotographsOf = ScratchFolder;

TEST_F(PhotographsOf, TheirCameraIsThatOfTheSmallPicture) {
  mrpt::img::CImage red(640, 480, mrpt::img::CH_RGB);
  const auto place = static_cast<std::int8_t>(red.getChannelsOrder().find('R'));
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      for (std::int8_t c = 0; c < 3; ++c) {
        *red.ptr<std::uint8_t>(x, y, c) = c == place ? 250 : 20;
      }
    }
  }
  const auto seen = observation(red);
  seen->cameraParams.ncols = 1280;  // calibrated at twice the size
  seen->cameraParams.nrows = 960;
  seen->cameraParams.setIntrinsicParamsFromValues(1000, 1100, 640, 470);
  seen->cameraPose = mrpt::poses::CPose3D(0.5, 0, 1, -M_PI / 2, 0, -M_PI / 2);
  Photographs photographs;
  photographs.add(7, {seen}, at("a.rawlog"));
  const Json json = photographs.json();
  ASSERT_EQ(json["list"].size(), 1U);
  const Json& one = json["list"][0];
  EXPECT_EQ(one["k"], 7);
  EXPECT_EQ(one["sensor"], "left");
  EXPECT_EQ(one["size"], (std::vector<int>{320, 240}));
  EXPECT_EQ(one["camera"]["f"], (std::vector<double>{250, 275}));
  EXPECT_EQ(one["camera"]["c"], (std::vector<double>{160, 117.5}));
  const std::vector<double> ahead{0, 0, 1, 0.5, -1, 0, 0, 0, 0, -1, 0, 1};
  EXPECT_EQ(one["camera"]["T"].get<std::vector<double>>(), ahead);
  mrpt::img::CImage loaded;
  ASSERT_TRUE(loaded.loadFromFile(write("one.jpg", bytes_of(one["jpeg"]))));
  const Image shown = image_of(loaded);
  ASSERT_EQ(shown.width, 320);
  ASSERT_EQ(shown.height, 240);
  const std::uint8_t* middle = &shown.rgb[3 * (320 * 120 + 160)];
  EXPECT_GT(middle[0], 230);
  EXPECT_LT(middle[2], 40);
}

TEST_F(PhotographsOf, ACameraThatNobodyCalibratedIsUnknown) {
  Photographs photographs;
  photographs.add(0, {observation(noise(100, 80, 1))}, at("a.rawlog"));
  const Json one = photographs.json()["list"][0];
  EXPECT_TRUE(one["camera"].is_null());
  EXPECT_EQ(one["size"], (std::vector<int>{100, 80}));  // small enough as it is
}

TEST_F(PhotographsOf, EveryOtherGoesWhereTheyAreTooMany) {
  Photographs photographs;
  const auto seen = observation(noise(320, 240, 1));
  for (int k = 0; k < 200; ++k) photographs.add(k, {seen}, at("a.rawlog"));
  const Json json = photographs.json();
  std::size_t bytes = 0;
  const int every = json["every"];
  EXPECT_GT(every, 1);
  for (std::size_t i = 0; i < json["list"].size(); ++i) {
    EXPECT_EQ(json["list"][i]["k"], static_cast<int>(i) * every);
    bytes += bytes_of(json["list"][i]["jpeg"]).size();
  }
  EXPECT_LE(bytes, Photographs::kMostBytes);
  EXPECT_GT(bytes, Photographs::kMostBytes / 3);
}

TEST_F(PhotographsOf, ALogMayNameFilesOfItsFolderAlone) {
  std::filesystem::create_directories(folder / "a_Images");
  const mrpt::img::CImage image = noise(60, 40, 3);
  ASSERT_TRUE(image.saveToFile(at("a_Images/one.png")));
  ASSERT_TRUE(image.saveToFile(at("outside.png")));
  ASSERT_EQ(::mkfifo(at("a_Images/pipe.png").c_str(), 0600), 0);
  std::filesystem::create_symlink(at("outside.png"), at("a_Images/link.png"));
  write("a_Images/black.png", black_png(64, 64));
  write("a_Images/bomb.png", black_png(8000, 7000));  // 9 kB, 56 million pixels
  ASSERT_TRUE(image.saveToFile(at("a_Images/two.jpg")));
  Photographs photographs;
  for (const std::string name :
       {"one.png", "../outside.png", "missing.png", "..", ".", "", "pipe.png", "link.png",
        "black.png", "bomb.png", "bomb.png", "two.jpg"}) {
    mrpt::img::CImage named;
    named.setExternalStorage(name);
    photographs.add(0, {observation(named)}, at("a.rawlog"));
  }
  photographs.add(0, {observation(noise(60, 40, 4)), CObservationImage::Create()}, at("a.rawlog"));
  const Json json = photographs.json();
  EXPECT_EQ(json["list"].size(), 4U);
  EXPECT_EQ(json["unreadable"], 10);
}

}  // namespace
}  // namespace hybrid
