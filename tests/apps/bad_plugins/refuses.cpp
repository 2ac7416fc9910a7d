// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A plugin that is at fault in four keyframes: it throws, adds a landmark that its one range does
// not determine, adds a factor of a pose that does not exist, and throws what is no exception. If
// asked, it ends the program or waits for ever.

#include <unistd.h>

#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/range.h"
#include "mrpt_plugins/mapping/register_plugin.h"

namespace bad {

/// Once the program has set its alarm of 30 s, time goes faster: it rings after one.
[[noreturn]] void wait_for_ever() {
  constexpr unsigned kAlarm = 30, kLooks = 10;  // s, and of them in a second
  unsigned left = 0;
  do {
    ::usleep(1000000 / kLooks);
    left = ::alarm(0);
  } while (left + 5 < kAlarm || left > kAlarm);
  ::alarm(1);
  for (;;) ::pause();
}

class Refuses : public hybrid::MappingPlugin {
  DEFINE_MRPT_OBJECT(Refuses, bad)

 public:
  void configure(hybrid::IniSection section) override {
    end_ = section.get("end", "", "exit or wait: how the first keyframe ends");
  }

  hybrid::Contribution observe(const hybrid::Frame& frame, const hybrid::MapView&) override {
    hybrid::Contribution out;
    ++frames_;
    if (end_ == "exit") std::exit(0);
    if (end_ == "wait") wait_for_ever();
    if (frames_ == 3) throw std::runtime_error("a lens cap");
    if (frames_ == 9) throw 9;
    if (frames_ == 5) {
      const hybrid::Key point('p', 0);
      out.delta.values.insert(point, Eigen::Vector2d(1, 2));
      out.delta.continuous.push_back(std::make_shared<hybrid::Range<hybrid::SE2, Eigen::Vector2d>>(
          frame.pose, point, 2, hybrid::Noise::unit(1)));
    }
    if (frames_ == 7) {
      out.delta.continuous.push_back(std::make_shared<hybrid::BetweenSE2>(
          frame.pose, hybrid::Key('x', 1000000), hybrid::SE2(), hybrid::Noise::unit(3)));
    }
    return out;
  }

 private:
  int frames_ = 0;
  std::string end_;
};

}  // namespace bad

HYBRID_REGISTER_PLUGIN(Refuses, bad)
