// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/drawing/detail/font.h"

#include <cairo-ft.h>
#include <fontconfig/fontconfig.h>

#include <memory>
#include <vector>

#include "mrpt_plugins/drawing/detail/cairo.h"

namespace hybrid::font {
namespace {

using Face = std::unique_ptr<cairo_font_face_t, cairo::Release<cairo_font_face_destroy>>;
using Options = std::unique_ptr<cairo_font_options_t, cairo::Release<cairo_font_options_destroy>>;
using ScaledFont = std::unique_ptr<cairo_scaled_font_t, cairo::Release<cairo_scaled_font_destroy>>;
using Pattern = std::unique_ptr<FcPattern, cairo::Release<FcPatternDestroy>>;
using Fonts = std::unique_ptr<FcFontSet, cairo::Release<FcFontSetSortDestroy>>;

constexpr char32_t kUnknown = 0xFFFD;

/// The first character of `text` from `at` on, which is moved behind it.
char32_t next_character(const std::string& text, std::size_t& at) {
  FcChar32 character = 0;
  const int length = FcUtf8ToUcs4(reinterpret_cast<const FcChar8*>(text.data()) + at, &character,
                                  static_cast<int>(text.size() - at));
  const bool is_surrogate = character >= 0xD800 && character <= 0xDFFF;
  if (length <= 0 || character > 0x10FFFF || is_surrogate) {
    ++at;
    return kUnknown;
  }
  at += static_cast<std::size_t>(length);
  return character < 0x20 || character == 0x7F ? U' ' : static_cast<char32_t>(character);
}

void append_utf8(std::string& text, char32_t character) {
  FcChar8 bytes[FC_UTF8_MAX_LEN];
  const int length = FcUcs4ToUtf8(static_cast<FcChar32>(character), bytes);
  text.append(reinterpret_cast<const char*>(bytes), static_cast<std::size_t>(length));
}

/// The same pixels whatever the user's settings of fonts are.
Options font_options() {
  Options options(cairo_font_options_create());
  cairo_font_options_set_antialias(options.get(), CAIRO_ANTIALIAS_GRAY);
  cairo_font_options_set_hint_style(options.get(), CAIRO_HINT_STYLE_NONE);
  cairo_font_options_set_hint_metrics(options.get(), CAIRO_HINT_METRICS_OFF);
  return options;
}

ScaledFont scaled(cairo_font_face_t* face, double size) {
  cairo_matrix_t scale, identity;
  cairo_matrix_init_scale(&scale, size, size);
  cairo_matrix_init_identity(&identity);
  ScaledFont out(cairo_scaled_font_create(face, &scale, &identity, font_options().get()));
  cairo::check(cairo_scaled_font_status(out.get()));
  return out;
}

/// Characters that one font has.
struct Run {
  cairo_font_face_t* face;
  std::string text;
};

/// The fonts of a weight, the preferred one first.
class Family {
 public:
  explicit Family(bool bold) {
    const Pattern wanted(FcPatternCreate());
    if (!wanted) throw std::bad_alloc();
    for (const char* name : {"DejaVu Sans", "sans-serif"}) {
      FcPatternAddString(wanted.get(), FC_FAMILY, reinterpret_cast<const FcChar8*>(name));
    }
    FcPatternAddInteger(wanted.get(), FC_WEIGHT, bold ? FC_WEIGHT_BOLD : FC_WEIGHT_REGULAR);
    FcPatternAddBool(wanted.get(), FC_SCALABLE, FcTrue);
    FcConfigSubstitute(nullptr, wanted.get(), FcMatchPattern);
    FcDefaultSubstitute(wanted.get());
    FcResult result = FcResultMatch;
    fonts_.reset(FcFontSort(nullptr, wanted.get(), FcTrue, nullptr, &result));
    for (int i = 0; fonts_ && i < fonts_->nfont; ++i) {
      const Pattern font(FcPatternDuplicate(fonts_->fonts[i]));
      if (!font) throw std::bad_alloc();
      faces_.emplace_back(cairo_ft_font_face_create_for_pattern(font.get()));
    }
    if (faces_.empty()) {  // Cairo's own, which needs no file
      faces_.emplace_back(
          cairo_toy_font_face_create("sans-serif", CAIRO_FONT_SLANT_NORMAL,
                                     bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL));
    }
    for (const Face& face : faces_) cairo::check(cairo_font_face_status(face.get()));
    constexpr double kLarge = 1000;
    cairo_text_extents_t extent;
    cairo_scaled_font_text_extents(scaled(faces_[0].get(), kLarge).get(), "H", &extent);
    size_per_capital_ = extent.height > 0 ? kLarge / extent.height : 1.4;
  }

  double size(double capitals) const { return capitals * size_per_capital_; }

  std::vector<Run> runs(const std::string& text) const {
    std::vector<Run> out;
    for (std::size_t at = 0; at < text.size();) {
      const char32_t character = next_character(text, at);
      cairo_font_face_t* face = face_with(character);
      if (out.empty() || out.back().face != face) out.push_back({face, ""});
      append_utf8(out.back().text, character);
    }
    return out;
  }

 private:
  cairo_font_face_t* face_with(char32_t character) const {
    for (int i = 0; fonts_ && i < fonts_->nfont; ++i) {
      FcCharSet* covered = nullptr;
      FcPatternGetCharSet(fonts_->fonts[i], FC_CHARSET, 0, &covered);
      if (covered != nullptr && FcCharSetHasChar(covered, static_cast<FcChar32>(character))) {
        return faces_[static_cast<std::size_t>(i)].get();
      }
    }
    return faces_[0].get();
  }

  Fonts fonts_;
  std::vector<Face> faces_;
  double size_per_capital_ = 1;
};

const Family& family(bool bold) {
  static const Family kRegular(false), kBold(true);
  return bold ? kBold : kRegular;
}

}  // namespace

double width(const std::string& text, double capitals, bool bold) {
  const Family& fonts = family(bold);
  double sum = 0;
  for (const Run& run : fonts.runs(text)) {
    cairo_text_extents_t extent;
    const ScaledFont font = scaled(run.face, fonts.size(capitals));
    cairo_scaled_font_text_extents(font.get(), run.text.c_str(), &extent);
    cairo::check(cairo_scaled_font_status(font.get()));
    sum += extent.x_advance;
  }
  return sum;
}

namespace {

template <class Each>
void for_each_run(cairo_t* context, const std::string& text, double capitals, bool bold,
                  const Each& each) {
  const Family& fonts = family(bold);
  cairo_set_font_options(context, font_options().get());
  for (const Run& run : fonts.runs(text)) {
    cairo_set_font_face(context, run.face);
    cairo_set_font_size(context, fonts.size(capitals));
    each(context, run.text.c_str());
  }
}

}  // namespace

void draw(cairo_t* context, const std::string& text, double capitals, bool bold) {
  for_each_run(context, text, capitals, bold, cairo_show_text);
}

void add_outline(cairo_t* context, const std::string& text, double capitals, bool bold) {
  for_each_run(context, text, capitals, bold, cairo_text_path);
}

}  // namespace hybrid::font
