// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/sandbox.h"

#include <seccomp.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>

namespace hybrid {
namespace {

void set_limit(__rlimit_resource_t resource, std::uint64_t value, std::uint64_t grace = 0) {
  const rlimit limit{value, value + grace};
  ::setrlimit(resource, &limit);
}

/// Size of the address space now [bytes]; 0 where the system does not tell.
std::uint64_t address_space() {
  unsigned long pages = 0;
  FILE* file = std::fopen("/proc/self/statm", "re");
  if (file == nullptr) return 0;
  if (std::fscanf(file, "%lu", &pages) != 1) pages = 0;
  std::fclose(file);
  return std::uint64_t{pages} * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

/// Descriptors that poll() may take at a time, which is the limit of open ones too: all numbers
/// below it are those of /dev/null, so that none can be opened.
constexpr std::uint64_t kPolled = 2;

constexpr int kAllowed[] = {
    SCMP_SYS(read),          SCMP_SYS(write),        SCMP_SYS(brk),
    SCMP_SYS(munmap),        SCMP_SYS(mremap),       SCMP_SYS(madvise),
    SCMP_SYS(futex),         SCMP_SYS(exit),         SCMP_SYS(exit_group),
    SCMP_SYS(rt_sigreturn),  SCMP_SYS(rt_sigaction), SCMP_SYS(rt_sigprocmask),
    SCMP_SYS(sigaltstack),   SCMP_SYS(getpid),       SCMP_SYS(gettid),
    SCMP_SYS(clock_gettime), SCMP_SYS(gettimeofday), SCMP_SYS(getrandom),
    SCMP_SYS(sched_yield),   SCMP_SYS(poll),         SCMP_SYS(ppoll),
};

/// Lets memory be mapped and protected, but none that can be executed.
int allow_memory(scmp_filter_ctx filter) {
  const auto no_code = SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0);
  const int mapping = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(mmap), 1, no_code);
  const int protecting = seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(mprotect), 1, no_code);
  return mapping != 0 ? mapping : protecting;
}

/// Lets the process signal itself, as abort() does.
int allow_abort(scmp_filter_ctx filter) {
  const auto self = static_cast<scmp_datum_t>(::getpid());
  return seccomp_rule_add(filter, SCMP_ACT_ALLOW, SCMP_SYS(tgkill), 1, SCMP_A0(SCMP_CMP_EQ, self));
}

bool filter_system_calls() {
  const scmp_filter_ctx filter = seccomp_init(SCMP_ACT_ERRNO(EPERM));
  if (filter == nullptr) return false;
  // For threads too that a library of the user may have started.
  bool is_complete = seccomp_attr_set(filter, SCMP_FLTATR_CTL_TSYNC, 1) == 0 &&
                     allow_memory(filter) == 0 && allow_abort(filter) == 0;
  for (const int call : kAllowed) {
    is_complete = is_complete && seccomp_rule_add(filter, SCMP_ACT_ALLOW, call, 0) == 0;
  }
  const bool is_loaded = is_complete && seccomp_load(filter) == 0;
  seccomp_release(filter);
  return is_loaded;
}

}  // namespace

ParserLimits parser_limits(std::optional<std::uint64_t> file_bytes) {
  constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
  constexpr std::uint64_t kMost = 4096 * kMiB;
  if (!file_bytes) return {kMost, 0};
  return {std::min(256 * kMiB + 16 * std::min(*file_bytes, kMost), kMost),
          20 + *file_bytes / (64 * 1024)};
}

bool confine_process(const ParserLimits& limits) {
  const std::uint64_t now = address_space();
  set_limit(now > 0 ? RLIMIT_AS : RLIMIT_DATA, now + limits.memory);
  if (limits.seconds > 0) {
    set_limit(RLIMIT_CPU, limits.seconds, 1);  // SIGXCPU first, which tells the reason
  }
  set_limit(RLIMIT_CORE, 0);
  set_limit(RLIMIT_FSIZE, 0);
  set_limit(RLIMIT_NOFILE, kPolled);
  return filter_system_calls();
}

}  // namespace hybrid
