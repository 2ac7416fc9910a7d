// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <memory>
#include <optional>
#include <string_view>

#include "libhybrid/export.h"
#include "mrpt_plugins/drawing/image.h"
#include "mrpt_plugins/drawing/photograph.h"

namespace HYBRID_API hybrid {

class DecodingProcess;

/// Makes small pictures of the bytes of picture files in a process of its own, which is confined as
/// that which parses logs (sandbox.h): what a decoder can be led to by bytes of somebody else ends
/// there. One process serves many pictures, one after the other.
class ImageDecoder {
 public:
  /// Pictures will be at most `width` pixels wide, at least one.
  explicit ImageDecoder(int width);
  ~ImageDecoder();

  /// The small picture; nothing where the bytes are no picture, or lead to the end of the process:
  /// by a crash, more than 512 MiB, or more than 20 s. Another process takes the next picture, up
  /// to ten times; then nothing is decoded any more. Throws Error if no process can be started, and
  /// Interrupted on a signal.
  std::optional<Image> decode(std::string_view bytes);

 private:
  std::unique_ptr<DecodingProcess> process_;
};

/// The same for depth images, which keep their size.
class DepthDecoder {
 public:
  DepthDecoder();
  ~DepthDecoder();

  /// Nothing also where an image has more than 2^26 pixels.
  std::optional<DepthImage> decode(std::string_view bytes);

 private:
  std::unique_ptr<DecodingProcess> process_;
};

}  // namespace hybrid
