// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/plugin_library.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <exception>
#include <filesystem>
#include <optional>
#include <set>

#include "libhybrid/core/error.h"
#include "libhybrid/io/regular_file.h"
#include "mrpt_plugins/mapping/plugin_tag.h"

namespace hybrid {
namespace {

/// Numbers of classes that a library registers.
struct Findings {
  std::size_t plugins = 0, classes = 0;
};

void* open_library(const std::string& path) {
  void* library = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) throw Error(::dlerror());
  return library;
}

std::size_t count_plugins() {
  return mrpt::rtti::getAllRegisteredClassesChildrenOf(CLASS_ID(MappingPlugin)).size();
}

Findings look_into(const std::string& path) {
  Findings found;
  const std::size_t plugins = count_plugins();
  const std::size_t classes = mrpt::rtti::getAllRegisteredClasses().size();
  open_library(path);
  found.plugins = count_plugins() - plugins;
  found.classes = mrpt::rtti::getAllRegisteredClasses().size() - classes;
  return found;
}

void write_all(int pipe, const void* data, std::size_t size) {
  const char* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t written = ::write(pipe, at, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return;
    at += written;
    size -= static_cast<std::size_t>(written);
  }
}

int report_pipe = -1;  // of the child, for terminate handlers

[[noreturn]] void report_failure(const std::string& why) {
  write_all(report_pipe, "-", 1);
  write_all(report_pipe, why.data(), why.size());
  ::_exit(0);
}

/// Terminate handler: exceptions of the library's static objects cannot be caught.
[[noreturn]] void report_exception() {
  try {
    std::rethrow_exception(std::current_exception());
  } catch (const std::exception& e) {
    report_failure(std::string("throws while it is loaded: ") + e.what());
  } catch (...) {
    report_failure("throws while it is loaded");
  }
}

/// Runs in the child. Writes `+` and the findings, or `-` and the reason of a failure.
[[noreturn]] void report(const std::string& path) {
  std::set_terminate(report_exception);
  try {
    const Findings found = look_into(path);
    write_all(report_pipe, "+", 1);
    write_all(report_pipe, &found, sizeof(found));
  } catch (const std::exception& e) {
    report_failure(e.what());
  }
  ::_exit(0);
}

std::string read_all(int pipe) {
  std::string text;
  std::array<char, 4096> part{};
  for (ssize_t got = 1; got != 0;) {
    got = ::read(pipe, part.data(), part.size());
    if (got < 0 && errno != EINTR) break;
    if (got > 0) text.append(part.data(), static_cast<std::size_t>(got));
  }
  return text;
}

/// Loads the library in a child process and returns its findings.
Findings probe(const std::string& path) {
  std::array<int, 2> pipe{};
  if (::pipe(pipe.data()) != 0) throw Error(std::strerror(errno));
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(pipe[0]);
    report_pipe = pipe[1];
    report(path);
  }
  ::close(pipe[1]);
  const std::string text = child > 0 ? read_all(pipe[0]) : "";
  ::close(pipe[0]);
  if (child < 0) throw Error(std::strerror(errno));
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status)) {
    throw Error(
        fmt::format("ends the process while it is loaded ({}); libraries must be built for {}",
                    ::strsignal(WTERMSIG(status)), to_string(hybrid_plugin_abi)));
  }
  if (text.empty()) throw Error("ends the process while it is loaded");
  Findings found;
  if (text[0] == '-' || text.size() != 1 + sizeof(found)) throw Error(text.substr(1));
  std::memcpy(&found, text.data() + 1, sizeof(found));
  return found;
}

/// An MRPT_VERSION as text: four bits for each of its three numbers in MRPT 2.5, eight in MRPT 3.
std::string mrpt_version(std::uint32_t version) {
  const int bits = version < 0x10000 ? 4 : 8;
  const std::uint32_t mask = (1U << bits) - 1;
  return fmt::format("{}.{}.{}", version >> (2 * bits), (version >> bits) & mask, version & mask);
}

void check(const PluginAbi& tag) {
  if (std::memcmp(&tag, &hybrid_plugin_abi, sizeof(PluginAbi)) == 0) return;
  const std::string own = to_string(hybrid_plugin_abi), theirs = to_string(tag);
  throw Error(own == theirs ? "was built with other headers of " + own + "; build it anew"
                            : fmt::format("was built for {}; this is {}", theirs, own));
}

void check(const Findings& found, bool has_tag) {
  if (!has_tag && found.plugins > 0) {
    throw Error("does not say what it was built for; use HYBRID_REGISTER_PLUGIN of " +
                to_string(hybrid_plugin_abi));
  }
  if (found.classes == 0) throw Error("registers no plugin");
}

}  // namespace

std::string to_string(const PluginAbi& abi) {
  return fmt::format("hybrid {}.{}.{} (MRPT {}, Eigen {}.{}.{} aligned to {} bytes)",
                     abi.version[0], abi.version[1], abi.version[2], mrpt_version(abi.mrpt),
                     abi.eigen[0], abi.eigen[1], abi.eigen[2], abi.alignment);
}

void load_plugin_library(const std::string& path) {
  const std::optional<PluginAbi> tag = find_plugin_tag(read_file(path));
  // An absolute path keeps the loader from searching the system's folders.
  const std::string absolute = std::filesystem::canonical(path).string();
  static std::set<std::string> loaded;
  if (loaded.count(absolute) != 0) return;
  try {
    if (tag) check(*tag);
    check(probe(absolute), tag.has_value());
    open_library(absolute);
    loaded.insert(absolute);
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", path, e.what()));
  }
}

}  // namespace hybrid
