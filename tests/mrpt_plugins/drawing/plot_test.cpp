// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/drawing/plot.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <thread>
#include <vector>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/drawing/axes.h"
#include "mrpt_plugins/drawing/heading.h"
#include "mrpt_plugins/drawing/labels.h"
#include "mrpt_plugins/output/figures.h"

namespace hybrid {
namespace {

/// Pixels of about the given colour.
int count(const Image& image, Color color) {
  int n = 0;
  for (std::size_t i = 0; i + 2 < image.rgb.size(); i += 3) {
    const int distance = std::abs(image.rgb[i] - color.red) +
                         std::abs(image.rgb[i + 1] - color.green) +
                         std::abs(image.rgb[i + 2] - color.blue);
    if (distance < 40) ++n;
  }
  return n;
}

TEST(Ticks, AreRoundInsideAndAboutAsManyAsAsked) {
  EXPECT_EQ(nice_ticks(0, 10, 5), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  EXPECT_EQ(nice_ticks(-1, 1, 4), (std::vector<double>{-1, -0.5, 0, 0.5, 1}));
  for (const double width : {1e-6, 0.37, 3.0, 98.0, 12345.0}) {
    const auto ticks = nice_ticks(7.3 - width, 7.3, 6);
    EXPECT_GE(ticks.size(), 2u) << width;
    EXPECT_LE(ticks.size(), 8u) << width;
    for (const double t : ticks) {
      EXPECT_GE(t, 7.3 - width * 1.001);
      EXPECT_LE(t, 7.3 + width * 0.001);
    }
  }
  EXPECT_TRUE(nice_ticks(1, 1, 5).empty());
  EXPECT_DOUBLE_EQ(nice_below(37), 20);
  EXPECT_DOUBLE_EQ(nice_below(0.051), 0.05);
  EXPECT_EQ(tick_text(0.5, 0.25), "0.5");
  EXPECT_EQ(tick_text(3, 1), "3");
}

TEST(Axes, MapCornersAndDecades) {
  const Axes axes({100, 50, 300, 250}, {"x", Scale::kLinear, {{-1, 1}}},
                  {"y", Scale::kLog, {{0.1, 10}}});
  EXPECT_NEAR((axes.pixel(-1, 0.1) - Pixel(100, 250)).norm(), 0, 1e-9);
  EXPECT_NEAR((axes.pixel(0, 1) - Pixel(200, 150)).norm(), 0, 1e-9);
  EXPECT_NEAR((axes.pixel(1, 10) - Pixel(300, 50)).norm(), 0, 1e-9);
  Axis x{"x", Scale::kLinear, {{0, 10}}};
  Axis y{"y", Scale::kLinear, {{0, 1}}};
  Axes::equalize({0, 0, 200, 100}, x, y);
  EXPECT_DOUBLE_EQ(x.range->second - x.range->first, 10);
  EXPECT_DOUBLE_EQ(y.range->second - y.range->first, 5);
  EXPECT_DOUBLE_EQ(y.range->first, -2);
}

TEST(Plot, DrawsEverySeriesInItsColourAndSkipsWhatHasNoPlace) {
  PlotSpec plot;
  plot.title = "A title";
  plot.y.scale = Scale::kLog;
  plot.width = 600;
  plot.height = 400;
  Series line;
  line.x = {0, 1, 2, 3, 4};
  line.y = {1, 10, std::nan(""), 0, 1000};
  line.color = {255, 0, 0};
  line.marker = Marker::kDiamond;
  Series dots = line;
  dots.line = LineStyle::kNone;
  dots.color = {0, 0, 255};
  dots.y = {2, 3, 4, 5, 6};
  plot.series = {line};
  const Image one = render(plot);
  plot.series.push_back(dots);
  const Image two = render(plot);
  EXPECT_EQ(one.width, 600);
  EXPECT_EQ(one.height, 400);
  EXPECT_EQ(one.rgb.size(), 600u * 400u * 3u);
  EXPECT_GT(count(one, {255, 0, 0}), 100);
  EXPECT_EQ(count(one, {0, 0, 255}), 0);
  EXPECT_GT(count(two, {0, 0, 255}), 100);
  EXPECT_EQ(png(one).substr(1, 3), "PNG");
}

/// The last row of pixels most of which are dark: the lower edge of the frame.
int lower_edge(const Image& image) {
  for (int y = image.height - 1; y >= 0; --y) {
    int dark = 0;
    for (int x = 0; x < image.width; ++x) {
      if (image.rgb[3 * (static_cast<std::size_t>(y) * image.width + x)] < 100) ++dark;
    }
    if (2 * dark > image.width) return y;
  }
  return -1;
}

TEST(Plot, NotesStayInsideOfTheFrame) {
  PlotSpec plot;
  plot.width = plot.height = 600;
  plot.x.range = plot.y.range = {{-0.02, 1.02}};
  Series points;
  points.x = {0, 0.5, 1};
  points.y = {0, 0, 0};
  points.marker = Marker::kCircle;
  plot.series = {points};
  const Image without = render(plot);
  plot.series[0].notes = {"n = 87971", "n = 5", "n = 42006"};
  const Image with = render(plot);
  EXPECT_NE(with.rgb, without.rgb);
  const int edge = lower_edge(without);
  ASSERT_GT(edge, 300);
  const auto from = static_cast<std::ptrdiff_t>(3) * (edge - 2) * without.width;
  EXPECT_TRUE(std::equal(with.rgb.begin() + from, with.rgb.end(), without.rgb.begin() + from));
}

/// Whether the outermost columns of a picture are white.
bool has_margin(const Image& image, int columns) {
  for (int y = 0; y < image.height; ++y) {
    for (int x = image.width - columns; x < image.width; ++x) {
      if (image.rgb[3 * (static_cast<std::size_t>(y) * image.width + x)] < 200) return false;
    }
  }
  return true;
}

TEST(Plot, TitlesAndSubtitlesOfAnyLengthStayInside) {
  PlotSpec plot;
  plot.width = 600;
  plot.height = 500;
  plot.title = "Inlier probabilities of a method with a very long name";
  plot.subtitle = "259193 loop closures, Brier score 0.00037, log loss 0.0007, error 0.00021";
  EXPECT_TRUE(has_margin(render(plot), 10));
  for (int i = 0; i < 30; ++i) plot.subtitle += ", replay " + std::to_string(i);
  EXPECT_TRUE(has_margin(render(plot), 10));
  Calibration many;
  many.predictions = 259193;
  many.brier = many.log_loss = many.expected_error = 0.00037;
  EXPECT_TRUE(has_margin(reliability_image(many, "Inlier probabilities"), 10));
}

TEST(Heading, GetsSmallerThenGoesOnInFurtherRows) {
  Canvas canvas(400, 300);
  EXPECT_EQ(draw_heading(canvas, {10, 20}, 380, "", ""), 0);
  EXPECT_EQ(draw_heading(canvas, {10, 20}, 380, "Title", ""), 34);
  EXPECT_EQ(draw_heading(canvas, {10, 20}, 380, "Title", "short"), 68);
  EXPECT_EQ(draw_heading(canvas, {10, 20}, 380, "Title", "a row that is a little longer than that"),
            68);
  const std::string words = "words that take rather more than one row of this canvas do";
  EXPECT_GT(draw_heading(canvas, {10, 20}, 380, "Title", words + " " + words), 68);
  TextStyle style;
  const std::vector<std::string> rows = wrapped(words, style, 200);
  EXPECT_GT(rows.size(), 1u);
  std::string joined;
  for (const std::string& row : rows) {
    EXPECT_LE(Canvas::text_extent(row, style).x(), 200);
    joined += (joined.empty() ? "" : " ") + row;
  }
  EXPECT_EQ(joined, words);
  EXPECT_EQ(wrapped("unbreakable", style, 1), std::vector<std::string>{"unbreakable"});
}

TEST(Plot, RefusesWhatCannotBeDrawn) {
  PlotSpec plot;
  plot.series.resize(1);
  plot.series[0].x = {1, 2};
  plot.series[0].y = {1};
  EXPECT_THROW(render(plot), std::invalid_argument);
  plot.series[0].y = {1, 2};
  plot.series[0].notes = {"a"};
  EXPECT_THROW(render(plot), std::invalid_argument);
  plot.series[0].notes.clear();
  plot.y.scale = Scale::kLog;
  plot.y.range = {{0.0, 1.0}};
  EXPECT_THROW(render(plot), std::invalid_argument);
  EXPECT_THROW(png({}), std::runtime_error);
}

TEST(Plot, EmptyAndConstantDataStillGiveAPicture) {
  PlotSpec plot;
  EXPECT_EQ(render(plot).width, 1600);
  plot.series.resize(1);
  plot.series[0].x = {1, 2};
  plot.series[0].y = {5, 5};
  EXPECT_GT(count(render(plot), palette::kEstimate), 100);
  EXPECT_EQ(steps_image({}, "none").width, 1400);
  EXPECT_EQ(error_image({}, {}, {}, "none").width, 1400);
  EXPECT_EQ(reliability_image(calibration({}), "none").width, 1000);
}

TEST(ErrorImage, CountsKeyframesWhereTheClockStandsStill) {
  std::vector<PosePair> pairs;
  for (int i = 0; i < 5; ++i) {
    PosePair pair;
    pair.estimate.x(0.1 * i * i);
    pairs.push_back(pair);
  }
  const Image timed = error_image({7.0, 8.0, 9.0, 10.0, 12.0}, pairs, {}, "errors");
  const Image glitch = error_image({7.0, 8.0, 8.0, 10.0, 12.0}, pairs, {}, "errors");
  const Image stopped = error_image({7.0, 7.0, 7.0, 7.0, 7.1}, pairs, {}, "errors");
  const Image still = error_image({3.0, 3.0, 3.0, 3.0, 3.0}, pairs, {}, "errors");
  EXPECT_NE(timed.rgb, stopped.rgb);
  EXPECT_NE(glitch.rgb, stopped.rgb);
  EXPECT_EQ(still.rgb, stopped.rgb);
}

TEST(Canvas, DashesLeaveGapsAndClippingHolds) {
  const auto ink = [](LineStyle style, bool clipped) {
    Canvas canvas(200, 40);
    if (clipped) canvas.clip({0, 0, 100, 40});
    canvas.line({10, 20}, {190, 20}, {{0, 0, 0}, 4, style});
    return count(canvas.image(), {0, 0, 0});
  };
  const int solid = ink(LineStyle::kSolid, false);
  EXPECT_NEAR(solid, 180 * 4, 120);
  EXPECT_LT(ink(LineStyle::kDashed, false), 0.85 * solid);
  EXPECT_LT(ink(LineStyle::kDotted, false), 0.7 * solid);
  EXPECT_EQ(ink(LineStyle::kNone, false), 0);
  EXPECT_NEAR(ink(LineStyle::kSolid, true), 0.5 * solid, 40);
}

TEST(Canvas, TextTakesTheSizeItSays) {
  TextStyle style;
  style.size = 20;
  const Eigen::Vector2d extent = Canvas::text_extent("HHHH", style);
  EXPECT_EQ(extent.y(), 20);
  Canvas canvas(200, 60);
  style.vertical = Align::kStart;
  canvas.text({20, 20}, "HHHH", style);
  const Image image = canvas.image();
  int top = 60, bottom = 0, left = 200, right = 0;
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 200; ++x) {
      if (image.rgb[3 * (y * 200 + x)] > 128) continue;
      top = std::min(top, y);
      bottom = std::max(bottom, y);
      left = std::min(left, x);
      right = std::max(right, x);
    }
  }
  EXPECT_NEAR(top, 20, 2);
  EXPECT_NEAR(bottom, 40, 3);
  EXPECT_NEAR(left, 21, 6);
  EXPECT_NEAR(right, 20 + extent.x(), 6);  // the last letter brings its own space
}

/// The pixels of a text alone.
Image written(const std::string& text) {
  Canvas canvas(220, 40);
  TextStyle style;
  style.size = 20;
  canvas.text({10, 20}, text, style);
  return canvas.image();
}

TEST(Canvas, TextIsUtf8) {
  const Image umlaut = written("Fußgänger");
  EXPECT_NE(umlaut.rgb, written("Fu??g??nger").rgb);
  EXPECT_NE(umlaut.rgb, written("Fu?g?nger").rgb);
  EXPECT_NE(umlaut.rgb, written("Fu\uFFFDg\uFFFDnger").rgb);
  EXPECT_NE(umlaut.rgb, written("Fußganger").rgb);  // the dots are there
  TextStyle style;
  const double wide = Canvas::text_extent("Fußgänger", style).x();
  EXPECT_NEAR(wide, Canvas::text_extent("Fusganger", style).x(), 0.1 * wide);  // no letter is two
  EXPECT_NE(written("信号").rgb, written("??????").rgb);
  // Bytes that are no UTF-8 are drawn as such, each.
  EXPECT_EQ(written("a\xFF\xC3").rgb, written("a\uFFFD\uFFFD").rgb);
  EXPECT_EQ(written("a\n").rgb, written("a").rgb);
}

TEST(Canvas, WhatIsFilledAfterATextBeginsAtItsOwnCorner) {
  Canvas canvas(100, 100);
  canvas.text({10, 15}, "text", {});
  canvas.fill({{60, 60}, {90, 60}, {90, 90}, {60, 90}}, {255, 0, 0});
  EXPECT_EQ(count(canvas.image(), {255, 0, 0}), 30 * 30);
}

TEST(Canvas, LinesAlongAnAxisKeepToPixels) {
  Canvas canvas(40, 40);
  canvas.line({5, 20}, {35, 20}, {{0, 0, 0}, 1});
  canvas.line({20.3, 25}, {20.3, 35}, {{0, 0, 0}, 2});
  EXPECT_EQ(count(canvas.image(), {0, 0, 0}), 30 + 2 * 10);
}

TEST(Canvas, LongLinesInPiecesAreWhole) {
  std::vector<Pixel> points;
  for (int i = 0; i <= 1000; ++i) points.emplace_back(10 + 0.18 * i, 20);
  for (const LineStyle style : {LineStyle::kSolid, LineStyle::kDashed, LineStyle::kDotted}) {
    Canvas pieces(200, 40), whole(200, 40);
    pieces.polyline(points, {{0, 0, 0}, 4, style});
    whole.polyline({points.front(), points.back()}, {{0, 0, 0}, 4, style});
    const int expected = count(whole.image(), {0, 0, 0});
    EXPECT_GT(expected, 100);
    EXPECT_NEAR(count(pieces.image(), {0, 0, 0}), expected, 0.02 * expected);
  }
}

TEST(Picture, AsLinesItHasTextsAndTheSameBytesEachTime) {
  const auto drawn = [](const std::string& label) {
    PlotSpec plot;
    plot.title = label;
    plot.width = plot.height = 400;
    plot.series.resize(1);
    plot.series[0].x = plot.series[0].y = {1, 2, 3};
    return render(plot);
  };
  const std::string svg = encoded(drawn("Fußgänger"), PictureFormat::kSvg);
  EXPECT_EQ(svg.rfind("<?xml", 0), 0U);
  EXPECT_EQ(svg.find("<image"), std::string::npos);  // no pixels
  EXPECT_NE(svg.find("<path"), std::string::npos);
  const std::string pdf = encoded(drawn("Fußgänger"), PictureFormat::kPdf);
  EXPECT_EQ(pdf.rfind("%PDF-", 0), 0U);
  EXPECT_EQ(pdf.find("CreationDate"), std::string::npos);
  written("something else between");
  EXPECT_EQ(encoded(drawn("Fußgänger"), PictureFormat::kSvg), svg);
  EXPECT_EQ(encoded(drawn("Fußgänger"), PictureFormat::kPdf), pdf);
  EXPECT_NE(encoded(drawn("other"), PictureFormat::kSvg), svg);
  // Pixels alone are put in as they are.
  Image pixels = drawn("a");
  pixels.drawing = nullptr;
  EXPECT_NE(encoded(pixels, PictureFormat::kSvg).find("<image"), std::string::npos);
  EXPECT_THROW(picture_format("gif"), Error);
  EXPECT_EQ(ending(picture_format("pdf")), ".pdf");
}

TEST(Picture, HasTheSamePixelsOnAnyThread) {
  const Image alone = written("Fußgänger 42");
  std::vector<Image> images(4);
  std::vector<std::thread> threads;
  for (Image& image : images) {
    threads.emplace_back([&image] {
      for (int i = 0; i < 10; ++i) image = written("Fußgänger 42");
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const Image& image : images) EXPECT_EQ(image.rgb, alone.rgb);
}

TEST(Canvas, CovarianceEllipseHasTheAxesOfTheCovariance) {
  Eigen::Matrix2d covariance;
  covariance << 4, 1.5, 1.5, 1;
  for (const auto& p : covariance_ellipse({1, 2}, covariance, 3)) {
    const Eigen::Vector2d d = p - Eigen::Vector2d(1, 2);
    EXPECT_NEAR(d.dot(covariance.inverse() * d), 9, 1e-9);
  }
}

TEST(LabelPlacer, NeverPutsATextOnAnother) {
  Canvas canvas(200, 200);
  LabelPlacer labels({0, 0, 200, 200});
  TextStyle style;
  style.size = 12;
  int placed = 0;
  for (int i = 0; i < 40; ++i) {
    if (labels.place(canvas, {100, 100}, 5, "1234", style)) ++placed;
  }
  EXPECT_GE(placed, 4);
  EXPECT_LE(placed, 12);
  EXPECT_FALSE(labels.place(canvas, {500, 100}, 5, "outside", style));
}

}  // namespace
}  // namespace hybrid
