// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/image_decoder.h"

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <string>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/rawlog/parser_main.h"
#include "mrpt_plugins/rawlog/parser_process.h"

namespace hybrid {
namespace {

constexpr ParserLimits kLimits{std::uint64_t{512} << 20, 0};
constexpr int kPatience = 20;  // for one picture [s]
constexpr std::size_t kMostLost = 10;
constexpr int kTallest = 100000;  // rows
constexpr std::size_t kMostPixels = std::size_t{1} << 26;

/// Two ends of a connection; signals of a broken one are left out, unlike those of a pipe.
struct Sockets {
  Sockets() {
    std::array<int, 2> both{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, both.data()) != 0) {
      throw Error(fmt::format("a process to decode pictures: {}", std::strerror(errno)));
    }
    ours = both[0];
    theirs = both[1];
    const timeval patience{kPatience, 0};
    ::setsockopt(ours, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof(patience));
  }
  ~Sockets() {
    ::close(ours);
    close_theirs();
  }
  Sockets(const Sockets&) = delete;
  Sockets& operator=(const Sockets&) = delete;
  void close_theirs() {
    if (theirs >= 0) ::close(theirs);
    theirs = -1;
  }

  int ours = -1, theirs = -1;
};

/// One process, until it is of no use any more.
class Attempt {
 public:
  explicit Attempt(int width)
      : process_(sockets_.theirs, {[width] { return decode_pictures(kLimits, width); },
                                   [width] { return decoder_command(kLimits, width); }}) {
    sockets_.close_theirs();
  }

  /// Whether all bytes were taken.
  bool send(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t put = ::send(sockets_.ours, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (put < 0 && errno == EINTR) continue;
      if (put <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(put));
    }
    return true;
  }
  /// Whether so many bytes of the answer have come.
  bool receive(std::size_t count) {
    while (answer_.size() < count) {
      if (process_.read(got_, kPatience) != ParserProcess::Got::kBytes) return false;
      answer_ += got_;
    }
    return true;
  }
  /// The first `count` bytes of the answer, which are taken from it.
  std::string take(std::size_t count) {
    std::string out = answer_.substr(0, count);
    answer_.erase(0, count);
    return out;
  }

 private:
  Sockets sockets_;
  ParserProcess process_;
  std::string got_, answer_;
};

struct Pixels {
  int width = 0, height = 0;
  std::string bytes;
};

}  // namespace

/// A process that decodes, followed by another one where it ends.
class DecodingProcess {
 public:
  /// Of depth images if `width` is 0, as decode_pictures() has it.
  explicit DecodingProcess(int width) : width_(width) {}

  std::optional<Pixels> decode(std::string_view bytes) {
    if (lost_ >= kMostLost) return std::nullopt;
    if (!attempt_) attempt_ = std::make_unique<Attempt>(width_);
    std::optional<Pixels> pixels = ask(bytes);
    if (!pixels) {
      attempt_.reset();
      ++lost_;
      return std::nullopt;
    }
    if (pixels->width == 0) return std::nullopt;
    return pixels;
  }

 private:
  /// Without pixels where the bytes are no picture; nothing if the process is of no use any more.
  std::optional<Pixels> ask(std::string_view bytes) {
    const std::uint64_t size = bytes.size();
    const std::string_view head(reinterpret_cast<const char*>(&size), sizeof(size));
    std::array<std::int32_t, 2> shape{};
    if (!attempt_->send(head) || !attempt_->send(bytes) || !attempt_->receive(sizeof(shape))) {
      return std::nullopt;
    }
    std::memcpy(shape.data(), attempt_->take(sizeof(shape)).data(), sizeof(shape));
    const auto [width, height] = shape;
    const int widest = width_ > 0 ? width_ : kTallest;
    if (width < 0 || height < 0 || width > widest || height > kTallest) return std::nullopt;
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    const std::size_t count = (width_ > 0 ? 3 : 2) * pixels;
    if (pixels > kMostPixels || !attempt_->receive(count)) return std::nullopt;
    return Pixels{width, height, attempt_->take(count)};
  }

  int width_;
  std::unique_ptr<Attempt> attempt_;
  std::size_t lost_ = 0;  // processes that ended before they were asked to
};

ImageDecoder::ImageDecoder(int width) : process_(std::make_unique<DecodingProcess>(width)) {}
ImageDecoder::~ImageDecoder() = default;

std::optional<Image> ImageDecoder::decode(std::string_view bytes) {
  const std::optional<Pixels> pixels = process_->decode(bytes);
  if (!pixels) return std::nullopt;
  return Image{pixels->width, pixels->height, {pixels->bytes.begin(), pixels->bytes.end()}};
}

DepthDecoder::DepthDecoder() : process_(std::make_unique<DecodingProcess>(0)) {}
DepthDecoder::~DepthDecoder() = default;

std::optional<DepthImage> DepthDecoder::decode(std::string_view bytes) {
  const std::optional<Pixels> pixels = process_->decode(bytes);
  if (!pixels) return std::nullopt;
  DepthImage image{pixels->width, pixels->height, {}};
  image.depths.resize(pixels->bytes.size() / sizeof(std::uint16_t));
  std::memcpy(image.depths.data(), pixels->bytes.data(), pixels->bytes.size());
  return image;
}

}  // namespace hybrid
