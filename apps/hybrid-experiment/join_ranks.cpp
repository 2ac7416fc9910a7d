// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-experiment/join_ranks.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <list>
#include <mutex>
#include <thread>

#include "apps/program.h"
#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/interrupt.h"
#ifdef HYBRID_MPI
#include <mpi.h>
#endif

namespace hybrid {
namespace {

/// How many processes the launcher started, by the variables that it sets.
int launched() {
  int most = 1;
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"}) {
    if (const char* value = std::getenv(name)) most = std::max(most, std::atoi(value));
  }
  return most;
}

#ifdef HYBRID_MPI

/// Whether the launcher told this process how to find the others. Without that, Open MPI would end
/// it.
bool has_address() {
  const auto names = {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK"};
  return std::any_of(names.begin(), names.end(),
                     [](const char* name) { return std::getenv(name) != nullptr; });
}

/// Ends this process where a call of MPI does not return, as some networks wait for ever for a rank
/// that was lost. What was written stays.
class Watchdog {
 public:
  ~Watchdog() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      over_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }
  void begin() { until_ = (Clock::now() + kPatience).time_since_epoch().count(); }
  void end() { until_ = 0; }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::seconds kPatience{10};

  void watch() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (!changed_.wait_for(lock, std::chrono::milliseconds(200), [&] { return over_; })) {
      const Clock::rep until = until_;
      if (until == 0 || Clock::now().time_since_epoch().count() < until) continue;
      complain("hybrid-experiment: MPI waits for a rank that was lost; run again to go on\n");
      // So that the launcher ends the others; it may not return either.
      std::thread([] { MPI_Abort(MPI_COMM_WORLD, EXIT_FAILURE); }).detach();
      std::this_thread::sleep_for(std::chrono::seconds(2));
      std::_Exit(EXIT_FAILURE);
    }
  }

  std::atomic<Clock::rep> until_{0};  // 0: no call is under way
  std::mutex mutex_;
  std::condition_variable changed_;
  bool over_ = false;
  std::thread thread_{[this] { watch(); }};  // the last member
};

/// All functions are called by the main thread. None takes longer than the watchdog allows.
class MpiChannel : public Channel {
 public:
  MpiChannel() {
    int provided = 0;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);
    MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
  }
  ~MpiChannel() override {
    constexpr std::chrono::seconds kPatience(10);  // for messages that nobody may receive
    const auto end = std::chrono::steady_clock::now() + kPatience;
    if (leaving_ || interrupted() != 0) return;  // the launcher ends the others
    while (pending() && std::chrono::steady_clock::now() < end) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    within_patience([] { return MPI_Finalize(); });  // it waits for all ranks
  }
  MpiChannel(const MpiChannel&) = delete;
  MpiChannel& operator=(const MpiChannel&) = delete;

  int rank() const override { return rank_; }
  int size() const override { return size_; }

  std::string host() const override {
    std::array<char, 256> name{};
    return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
  }

  void leave() override { leaving_ = true; }

  void send(int to, const std::string& text) override {
    sent_.push_back({text, MPI_REQUEST_NULL});
    Sent& sent = sent_.back();
    check(within_patience([&] {
      return MPI_Isend(sent.text.data(), static_cast<int>(sent.text.size()), MPI_CHAR, to, 0,
                       MPI_COMM_WORLD, &sent.request);
    }));
  }

  std::optional<Message> receive() override {
    pending();
    int found = 0, length = 0;
    MPI_Status status;
    check(within_patience(
        [&] { return MPI_Iprobe(MPI_ANY_SOURCE, 0, MPI_COMM_WORLD, &found, &status); }));
    if (found == 0) return std::nullopt;
    MPI_Get_count(&status, MPI_CHAR, &length);
    Message message{status.MPI_SOURCE, std::string(static_cast<std::size_t>(length), ' ')};
    check(within_patience([&] {
      return MPI_Recv(message.text.data(), length, MPI_CHAR, status.MPI_SOURCE, 0, MPI_COMM_WORLD,
                      MPI_STATUS_IGNORE);
    }));
    return message;
  }

 private:
  struct Sent {
    std::string text;
    MPI_Request request;
  };

  static void check(int code) {
    if (code == MPI_SUCCESS) return;
    std::array<char, MPI_MAX_ERROR_STRING> text{};
    int length = 0;
    MPI_Error_string(code, text.data(), &length);
    throw Error(fmt::format("MPI: {}", text.data()));
  }

  template <class Call>
  int within_patience(const Call& call) {
    watchdog_.begin();
    const int code = call();
    watchdog_.end();
    return code;
  }

  /// Whether a message is still on its way. Forgets the others.
  bool pending() {
    sent_.remove_if([this](Sent& sent) {
      int arrived = 0;
      const int code =
          within_patience([&] { return MPI_Test(&sent.request, &arrived, MPI_STATUS_IGNORE); });
      return code != MPI_SUCCESS || arrived != 0;
    });
    return !sent_.empty();
  }

  int rank_ = 0, size_ = 1;
  bool leaving_ = false;
  std::list<Sent> sent_;  // in memory that does not move
  Watchdog watchdog_;
};

#endif

}  // namespace

std::unique_ptr<Channel> join_ranks() {
  const int processes = launched();
  if (processes == 1) return nullptr;
#ifdef HYBRID_MPI
  if (has_address()) {
    auto channel = std::make_unique<MpiChannel>();
    if (channel->size() > 1) return channel;
  }
  throw Error(
      fmt::format("{} processes were started that do not find each other: under Slurm, use "
                  "srun --mpi=pmix, or mpirun inside the job",
                  processes));
#else
  throw Error(
      fmt::format("{} processes were started, and this program was built without MPI: "
                  "install libopenmpi-dev and configure with -DHYBRID_MPI=ON",
                  processes));
#endif
}

}  // namespace hybrid
