// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/parser_process.h"

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <filesystem>
#include <future>
#include <memory>
#include <thread>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/rawlog/object_reader.h"
#include "tests/mrpt_plugins/input/log_files.h"
#include "tests/mrpt_plugins/rawlog/compressed.h"
#include "tests/mrpt_plugins/rawlog/standard_input.h"

namespace hybrid {
namespace {

/// A second thread for as long as it lives, so that no fork is possible.
class Company {
 public:
  ~Company() {
    done_.set_value();
    thread_.join();
  }

 private:
  std::promise<void> done_;
  std::thread thread_{[this] { done_.get_future().wait(); }};
};

/// Once by fork, once by the program.
class ParserProcessTest : public ::testing::TestWithParam<bool> {
 protected:
  ParserProcessTest() {
    static void* const library = dlopen(HYBRID_HOSTILE_OBSERVATIONS, RTLD_NOW | RTLD_GLOBAL);
    EXPECT_NE(library, nullptr) << dlerror();
    if (GetParam()) company_ = std::make_unique<Company>();
  }

  /// Writes a log of two sound frames and, between them, an object of this class.
  void write_with(const std::string& class_name) const {
    const auto hostile = std::dynamic_pointer_cast<mrpt::serialization::CSerializable>(
        mrpt::rtti::classFactory("hostile::" + class_name));
    ASSERT_TRUE(hostile) << class_name;
    write_log(log_.path(), {frame({observation(1)}), hostile, frame({observation(2)})});
  }

  const TemporaryFile log_{"hostile.rawlog"};

 private:
  std::unique_ptr<Company> company_;
};

INSTANTIATE_TEST_SUITE_P(Way, ParserProcessTest, ::testing::Bool(),
                         [](const auto& info) { return info.param ? "Program" : "Fork"; });

bool has_children() {
  return waitpid(-1, nullptr, WNOHANG) >= 0 || errno != ECHILD;
}

TEST_P(ParserProcessTest, CrashesAreNamedAndWhatCameBeforeIsUsed) {
  for (const std::string name : {"Crasher", "Aborter", "Leaver", "Deep"}) {
    write_with(name);
    ObjectReader log(log_.path(), {}, {HYBRID_HOSTILE_OBSERVATIONS});
    EXPECT_TRUE(log.next());
    EXPECT_FALSE(log.next());
    EXPECT_EQ(log.status(), LogStatus::kCorrupt);
    EXPECT_NE(log.message().find("at object 1: MRPT's parser crashed (hostile::" + name + ")"),
              std::string::npos)
        << log.message();
  }
  EXPECT_FALSE(has_children());
}

TEST_P(ParserProcessTest, MemoryIsLimited) {
  write_with("Hog");
  ObjectReader log(log_.path(), {}, {HYBRID_HOSTILE_OBSERVATIONS});
  EXPECT_TRUE(log.next());
  EXPECT_FALSE(log.next());
#ifndef __SANITIZE_ADDRESS__
  EXPECT_EQ(log.status(), LogStatus::kTooLarge);
  EXPECT_NE(log.message().find("256 MB"), std::string::npos) << log.message();
#endif
  EXPECT_NE(log.message().find("(hostile::Hog)"), std::string::npos) << log.message();
}

TEST_P(ParserProcessTest, NothingButParsingIsPossible) {
  write_with("Intruder");
  LogRequest request;
  request.classes = {"Intruder"};
  ObjectReader log(log_.path(), request, {HYBRID_HOSTILE_OBSERVATIONS});
  ASSERT_TRUE(log.next());
  const auto intruder = log.next();
  ASSERT_TRUE(intruder) << log.message();
  ASSERT_TRUE(log.notes().empty()) << log.notes()[0];
  EXPECT_EQ(std::get<LoggedObservation>(*intruder).content->sensorLabel, "nothing");
  EXPECT_TRUE(log.next());
  EXPECT_EQ(log.status(), LogStatus::kReading);
}

TEST_P(ParserProcessTest, TimeIsLimited) {
  write_with("Counter");
  const RegularFile file(log_.path());
  ParserProcess process(file.descriptor(), {std::uint64_t{1} << 28, 1}, {},
                        {HYBRID_HOSTILE_OBSERVATIONS});
  std::string bytes;
  ParserProcess::Got got = ParserProcess::Got::kBytes;
  while (got == ParserProcess::Got::kBytes) got = process.read(bytes, 60);
  EXPECT_EQ(got, ParserProcess::Got::kEnd);
  EXPECT_EQ(process.wait(), ParserProcess::Exit::kOutOfTime);
}

TEST_P(ParserProcessTest, AProcessThatIsSilentIsEndedWithItsReader) {
  write_with("Counter");
  {
    const RegularFile file(log_.path());
    ParserProcess process(file.descriptor(), parser_limits(1000), {},
                          {HYBRID_HOSTILE_OBSERVATIONS});
    std::string bytes;
    while (process.read(bytes, 2) == ParserProcess::Got::kBytes) {
    }
    EXPECT_TRUE(has_children());
  }
  EXPECT_FALSE(has_children());
}

TEST_P(ParserProcessTest, AReaderMayStopAnywhere) {
  const Objects objects(3000, frame({observation(1)}));
  write_log(log_.path(), objects);
  for (int taken = 0; taken < 3; ++taken) {
    ObjectReader log(log_.path());
    for (int i = 0; i < taken; ++i) EXPECT_TRUE(log.next());
  }
  EXPECT_FALSE(has_children());
}

TEST_P(ParserProcessTest, SeveralLogsAtATime) {
  write_log(log_.path(), Objects(500, frame({observation(1)})));
  ObjectReader a(log_.path()), b(log_.path());
  for (int i = 0; i < 500; ++i) EXPECT_TRUE(a.next() && b.next()) << i;
  EXPECT_FALSE(a.next() || b.next());
  EXPECT_EQ(a.status(), LogStatus::kComplete) << a.message();
  EXPECT_EQ(b.status(), LogStatus::kComplete) << b.message();
}

TEST_P(ParserProcessTest, NoDescriptorIsLeftOpen) {
  write_log(log_.path(), {frame({observation(1)})});
  const auto open_descriptors = [] {
    const std::filesystem::directory_iterator all("/proc/self/fd");
    return std::distance(begin(all), end(all));
  };
  const auto before = open_descriptors();
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(ObjectReader(log_.path()).next());
  EXPECT_EQ(open_descriptors(), before);
}

/// The bytes of an object in a plain log.
std::string bytes_of(const mrpt::serialization::CSerializable::Ptr& object) {
  const TemporaryFile file("object.rawlog");
  write_log(file.path(), {object});
  return decode(read_bytes(file.path())).bytes;
}

TEST_P(ParserProcessTest, AnObjectOfAPipeIsGivenWhenItHasCome) {
  for (const bool is_compressed : {false, true}) {
    PipedInput input;
    const auto sent = [&](const std::string& bytes) { return is_compressed ? gzip(bytes) : bytes; };
    input.write(sent(bytes_of(frame({observation(0)}))));
    ObjectReader log("-");
    for (int i = 1; i < 5; ++i) {
      EXPECT_TRUE(log.next()) << i;
      EXPECT_EQ(log.progress(), std::nullopt);
      input.write(sent(bytes_of(frame({}))));  // shorter than any head that is looked at
      EXPECT_TRUE(log.next()) << i;
      input.write(sent(bytes_of(frame({observation(i)}))));
    }
    input.end();
    EXPECT_TRUE(log.next());
    EXPECT_FALSE(log.next());
    EXPECT_EQ(log.status(), LogStatus::kComplete) << log.message();
    EXPECT_EQ(log.objects(), 9U);
  }
}

TEST_P(ParserProcessTest, APipeThatEndsInsideOfAnObject) {
  PipedInput input;
  const std::string whole = bytes_of(frame({observation(0)}));
  input.write(whole + whole.substr(0, whole.size() / 2));
  input.end();
  ObjectReader log("-");
  EXPECT_TRUE(log.next());
  EXPECT_FALSE(log.next());
  EXPECT_EQ(log.status(), LogStatus::kTruncated);
  EXPECT_EQ(log.message(), "standard input: truncated at object 1: the file ends inside an object");
}

/// Kills a process once it has read with `read_some`, a function of a callback that tells so and
/// does not return. Gives how the process that parses for it ended.
template <class ReadSome>
void kill_reader(const ReadSome& read_some, int& status) {
  ASSERT_EQ(prctl(PR_SET_CHILD_SUBREAPER, 1), 0);  // its orphans become ours
  std::array<int, 2> ready{};
  ASSERT_EQ(pipe(ready.data()), 0);
  const pid_t reader = fork();
  if (reader == 0) {
    read_some([&] {
      if (write(ready[1], "x", 1) != 1) _exit(1);
      while (true) pause();
    });
  }
  char byte = 0;
  ASSERT_EQ(read(ready[0], &byte, 1), 1);
  kill(reader, SIGKILL);
  EXPECT_EQ(waitpid(reader, &status, 0), reader);
  EXPECT_GT(waitpid(-1, &status, 0), 0) << "the process that parses";
  for (const int end : ready) close(end);
}

TEST(ParserProcess, OfASilentPipeDoesNotOutliveAReaderThatIsKilled) {
  const PipedInput input;
  int status = 0;
  kill_reader(
      [](const auto& wait) {
        ParserProcess process(STDIN_FILENO, parser_limits(std::nullopt), {}, {});
        std::string bytes;
        process.read(bytes, 60);  // it has started
        wait();
      },
      status);
}

TEST(ParserProcess, DoesNotOutliveAReaderThatIsKilled) {
  const TemporaryFile log("outlive.rawlog");
  write_log(log.path(), Objects(3000, frame({observation(1)})));  // more than a pipe holds
  int status = 0;
  kill_reader(
      [&](const auto& wait) {
        ObjectReader objects(log.path());
        objects.next();
        wait();
      },
      status);
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGPIPE);
}

TEST(ParserLimits, GrowWithTheFileUpToABound) {
  EXPECT_EQ(parser_limits(0).memory, 256U << 20);
  EXPECT_EQ(parser_limits(1U << 20).memory, 272U << 20);
  EXPECT_EQ(parser_limits(std::uint64_t{1} << 60).memory, std::uint64_t{4} << 30);
  EXPECT_EQ(parser_limits(1U << 20).seconds, 36U);
  EXPECT_EQ(parser_limits(std::nullopt).memory, std::uint64_t{4} << 30);
  EXPECT_EQ(parser_limits(std::nullopt).seconds, 0U);
}

}  // namespace
}  // namespace hybrid
