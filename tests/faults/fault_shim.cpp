// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// To be preloaded into a program: one of its calls goes wrong, from the start of main() to its end.
//   HYBRID_FAULT_CALLS  disk: calls that change a disk; space: those of them that need room on it;
//                       open: openings of files that are there; memory: allocations
//   HYBRID_FAULT_AT     number of the call, counted from 1; 0: none
//   HYBRID_FAULT_HOW    once: this call fails; on: it and all after it; or the number of a signal
//                       that the process gets instead
//   HYBRID_FAULT_COUNT  file that gets the number of calls
// Processes that the program forks are left alone.

#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

extern "C" {
void* __libc_malloc(size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
void* __libc_memalign(size_t, size_t);
}

namespace {

enum class Calls { kNone, kDisk, kSpace, kOpen, kMemory };

std::atomic<bool> armed{false};
std::atomic<long> count{0};
Calls calls = Calls::kNone;
long at = 0;
bool goes_on = false;
int signal_number = 0;

template <class Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

/// Counts a call of the kind in question. Whether it goes wrong, with this error.
bool goes_wrong(int error) {
  const long number = ++count;
  if (at == 0 || (goes_on ? number < at : number != at)) return false;
  if (signal_number != 0) {
    if (number == at) syscall(SYS_kill, getpid(), signal_number);
    return false;
  }
  errno = error;
  return true;
}

/// Whether the call that is about to be made, which changes the disk, goes wrong.
bool fails(bool needs_space) {
  const bool counts = calls == Calls::kDisk || (calls == Calls::kSpace && needs_space);
  return armed && counts && goes_wrong(ENOSPC);
}

bool cannot_open() {
  return armed && calls == Calls::kOpen && goes_wrong(EMFILE);
}

bool no_memory() {
  return armed && calls == Calls::kMemory && goes_wrong(ENOMEM);
}

void disarm() {
  armed = false;
}

const char* variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

/// Whether bytes at `end` would make a file longer; what it has already needs no room.
bool grows(int file, off64_t end) {
  struct stat64 status {};
  return fstat64(file, &status) != 0 || end > status.st_size;
}

int (*real_main)(int, char**, char**) = nullptr;

void read_settings() {
  const char* kind = variable("HYBRID_FAULT_CALLS");
  if (std::strcmp(kind, "disk") == 0) calls = Calls::kDisk;
  if (std::strcmp(kind, "space") == 0) calls = Calls::kSpace;
  if (std::strcmp(kind, "open") == 0) calls = Calls::kOpen;
  if (std::strcmp(kind, "memory") == 0) calls = Calls::kMemory;
  at = std::atol(variable("HYBRID_FAULT_AT"));
  goes_on = std::strcmp(variable("HYBRID_FAULT_HOW"), "on") == 0;
  signal_number = std::atoi(variable("HYBRID_FAULT_HOW"));
  unsetenv("LD_PRELOAD");  // not for programs that this one starts
}

int wrapped_main(int argc, char** argv, char** environment) {
  read_settings();
  pthread_atfork(nullptr, nullptr, disarm);
  armed = calls != Calls::kNone;
  const int code = real_main(argc, argv, environment);
  disarm();
  const char* file = variable("HYBRID_FAULT_COUNT");
  if (*file != '\0') {
    if (std::FILE* out = std::fopen(file, "w"); out != nullptr) {
      std::fprintf(out, "%ld\n", count.load());
      std::fclose(out);
    }
  }
  return code;
}

}  // namespace

extern "C" {

int __libc_start_main(int (*main)(int, char**, char**), int argc, char** argv, void (*init)(),
                      void (*fini)(), void (*rtld_fini)(), void* stack_end) {
  real_main = main;
  const auto start = next<decltype(&__libc_start_main)>("__libc_start_main");
  return start(wrapped_main, argc, argv, init, fini, rtld_fini, stack_end);
}

void* malloc(size_t size) {
  return no_memory() ? nullptr : __libc_malloc(size);
}
void* calloc(size_t number, size_t size) {
  return no_memory() ? nullptr : __libc_calloc(number, size);
}
void* realloc(void* old, size_t size) {
  return no_memory() ? nullptr : __libc_realloc(old, size);
}
void* memalign(size_t alignment, size_t size) {
  return no_memory() ? nullptr : __libc_memalign(alignment, size);
}
void* aligned_alloc(size_t alignment, size_t size) {
  return memalign(alignment, size);
}
int posix_memalign(void** out, size_t alignment, size_t size) {
  *out = memalign(alignment, size);
  return *out == nullptr ? ENOMEM : 0;
}

#define HYBRID_FAULT(type, name, needs_space, parameters, arguments) \
  type name parameters {                                             \
    if (fails(needs_space)) return -1;                               \
    static const auto real = next<type(*) parameters>(#name);        \
    return real arguments;                                           \
  }

HYBRID_FAULT(ssize_t, write, true, (int f, const void* b, size_t n), (f, b, n))
HYBRID_FAULT(ssize_t, pwrite, grows(f, o + static_cast<off64_t>(n)),
             (int f, const void* b, size_t n, off_t o), (f, b, n, o))
HYBRID_FAULT(ssize_t, pwrite64, grows(f, o + static_cast<off64_t>(n)),
             (int f, const void* b, size_t n, off64_t o), (f, b, n, o))
HYBRID_FAULT(ssize_t, writev, true, (int f, const iovec* v, int n), (f, v, n))
HYBRID_FAULT(int, mkdir, true, (const char* p, mode_t m), (p, m))
HYBRID_FAULT(int, link, true, (const char* a, const char* b), (a, b))
HYBRID_FAULT(int, rename, false, (const char* a, const char* b), (a, b))
HYBRID_FAULT(int, renameat2, false, (int f, const char* a, int g, const char* b, unsigned x),
             (f, a, g, b, x))
HYBRID_FAULT(int, unlink, false, (const char* p), (p))
HYBRID_FAULT(int, unlinkat, false, (int f, const char* p, int x), (f, p, x))
HYBRID_FAULT(int, remove, false, (const char* p), (p))
HYBRID_FAULT(int, rmdir, false, (const char* p), (p))
HYBRID_FAULT(int, fsync, false, (int f), (f))
HYBRID_FAULT(int, fdatasync, false, (int f), (f))
HYBRID_FAULT(int, ftruncate, false, (int f, off_t n), (f, n))
HYBRID_FAULT(int, ftruncate64, false, (int f, off64_t n), (f, n))
HYBRID_FAULT(int, chmod, false, (const char* p, mode_t m), (p, m))
HYBRID_FAULT(int, flock, false, (int f, int x), (f, x))

char* mkdtemp(char* name) {
  if (fails(true)) return nullptr;
  static const auto real = next<char* (*)(char*)>("mkdtemp");
  return real(name);
}

#define HYBRID_FAULT_OPEN(name, parameters, arguments)                     \
  int name parameters {                                                    \
    va_list rest;                                                          \
    va_start(rest, flags);                                                 \
    const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(rest, mode_t) : 0; \
    va_end(rest);                                                          \
    if ((flags & O_CREAT) != 0 ? fails(true) : cannot_open()) return -1;   \
    static const auto real = next<int(*) parameters>(#name);               \
    return real arguments;                                                 \
  }

HYBRID_FAULT_OPEN(open, (const char* p, int flags, ...), (p, flags, mode))
HYBRID_FAULT_OPEN(open64, (const char* p, int flags, ...), (p, flags, mode))
HYBRID_FAULT_OPEN(openat, (int f, const char* p, int flags, ...), (f, p, flags, mode))
HYBRID_FAULT_OPEN(openat64, (int f, const char* p, int flags, ...), (f, p, flags, mode))

#define HYBRID_FAULT_FOPEN(name)                                                    \
  std::FILE* name(const char* path, const char* mode) {                             \
    if (*mode == 'r' && cannot_open()) return nullptr;                              \
    static const auto real = next<std::FILE* (*)(const char*, const char*)>(#name); \
    return real(path, mode);                                                        \
  }

HYBRID_FAULT_FOPEN(fopen)
HYBRID_FAULT_FOPEN(fopen64)

}  // extern "C"
