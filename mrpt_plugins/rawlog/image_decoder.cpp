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
constexpr int kTallest = 100000;  // rows of a small picture

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

}  // namespace

class ImageDecoder::Process {
 public:
  explicit Process(int width)
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

ImageDecoder::ImageDecoder(int width) : width_(width) {}
ImageDecoder::~ImageDecoder() = default;

std::optional<Image> ImageDecoder::decode(std::string_view bytes) {
  if (lost_ >= kMostLost) return std::nullopt;
  if (!process_) process_ = std::make_unique<Process>(width_);
  std::optional<Image> image = attempt(bytes);
  if (!image) {
    process_.reset();
    ++lost_;
    return std::nullopt;
  }
  if (image->width == 0) return std::nullopt;
  return image;
}

/// Without pixels where the bytes are no picture; nothing if the process is of no use any more.
std::optional<Image> ImageDecoder::attempt(std::string_view bytes) {
  const std::uint64_t size = bytes.size();
  const std::string_view head(reinterpret_cast<const char*>(&size), sizeof(size));
  std::array<std::int32_t, 2> shape{};
  if (!process_->send(head) || !process_->send(bytes) || !process_->receive(sizeof(shape))) {
    return std::nullopt;
  }
  std::memcpy(shape.data(), process_->take(sizeof(shape)).data(), sizeof(shape));
  const auto [width, height] = shape;
  if (width < 0 || height < 0 || width > width_ || height > kTallest) return std::nullopt;
  const std::size_t pixels = 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  if (!process_->receive(pixels)) return std::nullopt;
  const std::string rgb = process_->take(pixels);
  return Image{width, height, {rgb.begin(), rgb.end()}};
}

}  // namespace hybrid
