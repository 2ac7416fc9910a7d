// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Observations whose parsing does what hostile bytes might make MRPT's parsers do: a library that
// the tests load as users load plugins.

#include <fcntl.h>
#include <mrpt/obs/CObservation.h>
#include <mrpt/serialization/CArchive.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "mrpt_plugins/mrpt_version.h"

namespace hostile {

/// Serialised as a text, which is what parsing an empty one led to.
class Observation : public mrpt::obs::CObservation {
 public:
  HYBRID_DEFINE_SENSOR_POSE(mrpt::poses::CPose3D())
  void setSensorPose(const mrpt::poses::CPose3D&) override {}
  std::uint8_t serializeGetVersion() const override { return 0; }
  void serializeTo(mrpt::serialization::CArchive& out) const override { out << sensorLabel; }
  void serializeFrom(mrpt::serialization::CArchive& in, std::uint8_t) override {
    in >> sensorLabel;
    if (sensorLabel.empty()) act();
  }

 protected:
  virtual void act() = 0;
};

/// Crashes.
class Crasher : public Observation {
  DEFINE_MRPT_OBJECT(Crasher, hostile)
  void act() override { std::raise(SIGSEGV); }
};

/// Aborts.
class Aborter : public Observation {
  DEFINE_MRPT_OBJECT(Aborter, hostile)
  void act() override { std::abort(); }
};

/// Leaves as if all were well.
class Leaver : public Observation {
  DEFINE_MRPT_OBJECT(Leaver, hostile)
  void act() override { std::_Exit(0); }
};

/// Calls itself until the stack is used up.
class Deep : public Observation {
  DEFINE_MRPT_OBJECT(Deep, hostile)
  void act() override { sensorLabel = std::to_string(depth(1)); }
  static int depth(int n) {
    volatile char room[4096];
    room[0] = static_cast<char>(n);
    return n == 0 ? room[0] : depth(n + 1) + room[0];
  }
};

/// Takes memory without end.
class Hog : public Observation {
  DEFINE_MRPT_OBJECT(Hog, hostile)
  void act() override {
    std::vector<std::vector<char>> all;
    while (true) all.emplace_back(std::size_t{1} << 20, 'x');
  }
};

/// Counts for ever.
class Counter : public Observation {
  DEFINE_MRPT_OBJECT(Counter, hostile)
  void act() override {
    volatile unsigned count = 0;
    while (true) count = count + 1;
  }
};

/// Names of what it can do of what a parser has no business to do.
class Intruder : public Observation {
  DEFINE_MRPT_OBJECT(Intruder, hostile)
  void act() override {
    const std::string file = "/proc/self/status";
    const auto tried = [this](const char* what, long result) {
      if (result >= 0) sensorLabel += std::string(what) + " ";
    };
    tried("open", ::open(file.c_str(), O_RDONLY));
    tried("create", ::open("hybrid_intruder", O_WRONLY | O_CREAT, 0600));
    tried("stat", ::access(file.c_str(), R_OK));
    tried("mkdir", ::mkdir("hybrid_intruder_folder", 0700));
    tried("socket", ::socket(AF_INET, SOCK_STREAM, 0));
    tried("unix-socket", ::socket(AF_UNIX, SOCK_STREAM, 0));
    tried("kill", ::kill(::getppid(), 0));
    tried("kill-group", ::kill(0, 0));
    tried("dup", ::dup(0));
    tried("chdir", ::chdir("/"));
    tried("execute", reinterpret_cast<long>(::mmap(nullptr, 4096, PROT_READ | PROT_EXEC,
                                                   MAP_PRIVATE | MAP_ANONYMOUS, -1, 0)) == -1
                         ? -1
                         : 0);
    const pid_t child = ::fork();
    if (child == 0) ::_exit(0);
    tried("fork", child);
    try {
      std::thread([] {}).join();
      tried("thread", 0);
    } catch (const std::exception&) {
    }
    if (sensorLabel.empty()) sensorLabel = "nothing";
  }
};

}  // namespace hostile

using mrpt::obs::CObservation;
IMPLEMENTS_MRPT_OBJECT(Crasher, CObservation, hostile)
IMPLEMENTS_MRPT_OBJECT(Aborter, CObservation, hostile)
IMPLEMENTS_MRPT_OBJECT(Leaver, CObservation, hostile)
IMPLEMENTS_MRPT_OBJECT(Deep, CObservation, hostile)
IMPLEMENTS_MRPT_OBJECT(Hog, CObservation, hostile)
IMPLEMENTS_MRPT_OBJECT(Counter, CObservation, hostile)
IMPLEMENTS_MRPT_OBJECT(Intruder, CObservation, hostile)

[[maybe_unused]] static const bool is_registered = [] {
  mrpt::rtti::registerClass(CLASS_ID(hostile::Crasher));
  mrpt::rtti::registerClass(CLASS_ID(hostile::Aborter));
  mrpt::rtti::registerClass(CLASS_ID(hostile::Leaver));
  mrpt::rtti::registerClass(CLASS_ID(hostile::Deep));
  mrpt::rtti::registerClass(CLASS_ID(hostile::Hog));
  mrpt::rtti::registerClass(CLASS_ID(hostile::Counter));
  mrpt::rtti::registerClass(CLASS_ID(hostile::Intruder));
  return true;
}();
