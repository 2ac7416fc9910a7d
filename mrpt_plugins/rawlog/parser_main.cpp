// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/rawlog/parser_main.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <new>
#include <string_view>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/drawing/photograph.h"
#include "mrpt_plugins/rawlog/asked_classes.h"
#include "mrpt_plugins/rawlog/detail/parse_log.h"

namespace hybrid {
namespace {

constexpr int kFailureCode = 1;

/// Waits until there is something to read, or an end of it. Ends the process where nobody reads any
/// more what it writes.
void await_log() {
  pollfd ends[] = {{kLogDescriptor, POLLIN, 0}, {kPipeDescriptor, 0, 0}};
  while (::poll(ends, std::size(ends), -1) < 0 && errno == EINTR) {
  }
  if (ends[1].revents != 0) ::_exit(kFailureCode);
}

std::size_t read_log(char* to, std::size_t count) {
  while (true) {
    await_log();
    const ssize_t got = ::read(kLogDescriptor, to, count);
    if (got >= 0) return static_cast<std::size_t>(got);
    if (errno != EINTR && errno != EAGAIN)
      throw Error(std::string("the file cannot be read: ") + std::strerror(errno));
  }
}

/// Ends the process where nobody reads any more.
void write_pipe(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t put = ::write(kPipeDescriptor, bytes.data(), bytes.size());
    if (put < 0 && errno != EINTR) ::_exit(kFailureCode);
    if (put > 0) bytes.remove_prefix(static_cast<std::size_t>(put));
  }
}

/// Leaves nothing open but what parsing needs, and all signals with their usual effect.
void clean_process() {
  ::close_range(kPipeDescriptor + 1, UINT_MAX, 0);
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  for (const int signal : {SIGPIPE, SIGXCPU, SIGINT, SIGTERM, SIGHUP}) ::signal(signal, SIG_DFL);
}

/// Folder of the library of this function.
std::filesystem::path library_folder() {
  Dl_info info{};
  if (::dladdr(reinterpret_cast<const void*>(&reader_command), &info) == 0) return {};
  return std::filesystem::path(info.dli_fname).parent_path();
}

/// The program of the library; throws Error where it is missing.
std::string reader_program() {
  for (const char* place : {HYBRID_READER_IN_BUILD, HYBRID_READER_INSTALLED}) {
    const auto program = (library_folder() / place).lexically_normal();
    if (std::filesystem::exists(program)) return program.string();
  }
  throw Error(
      fmt::format("{}: no such file; a process with several threads reads rawlogs by it",
                  (library_folder() / HYBRID_READER_INSTALLED).lexically_normal().string()));
}

/// So many bytes of the input, fewer at its end. Takes memory as they come.
std::string read_bytes(std::uint64_t count) {
  constexpr std::size_t kStep = std::size_t{1} << 20;
  std::string out;
  while (out.size() < count) {
    const std::size_t had = out.size();
    out.resize(had + std::min<std::uint64_t>(kStep, count - had));
    const std::size_t got = read_log(&out[had], out.size() - had);
    out.resize(had + got);
    if (got == 0) break;
  }
  return out;
}

template <class Number>
std::string_view bytes_of(const Number& number) {
  return {reinterpret_cast<const char*>(&number), sizeof(number)};
}

/// Columns, rows and pixels, as they are sent.
std::string to_bytes(int width, int height, std::string_view pixels) {
  std::string out(bytes_of(static_cast<std::int32_t>(width)));
  out += bytes_of(static_cast<std::int32_t>(height));
  return out += pixels;
}

template <class Pixel>
std::string_view bytes_of(const std::vector<Pixel>& pixels) {
  return {reinterpret_cast<const char*>(pixels.data()), pixels.size() * sizeof(Pixel)};
}

std::string small_picture(const std::string& bytes, int width) {
  const Image small = shrunk(decoded(bytes), width);
  return to_bytes(small.width, small.height, bytes_of(small.rgb));
}

std::string depth_image(const std::string& bytes) {
  const DepthImage image = decoded_depths(bytes);
  return to_bytes(image.width, image.height, bytes_of(image.depths));
}

std::string picture(const std::string& bytes, int width) try {
  return width > 0 ? small_picture(bytes, width) : depth_image(bytes);
} catch (const std::bad_alloc&) {
  throw;
} catch (const std::exception&) {
  return to_bytes(0, 0, {});
}

}  // namespace

int parse_into_pipe(const ParserLimits& limits, const LogRequest& request) try {
  clean_process();
  register_mrpt_classes();
  const AskedClasses asked(request.classes);
  const bool is_confined = confine_process(limits);
  write_pipe(to_bytes(ParserStarted{is_confined}, asked));
  parse_log(read_log, request,
            [&](const LogRecord& record) { write_pipe(to_bytes(record, asked)); });
  return 0;
} catch (const std::bad_alloc&) {
  return kOutOfMemoryCode;
} catch (...) {
  return kFailureCode;
}

int decode_pictures(const ParserLimits& limits, int width) try {
  clean_process();
  prepare_decoding();
  confine_process(limits);
  while (true) {
    std::uint64_t size = 0;
    const std::string head = read_bytes(sizeof(size));
    if (head.size() < sizeof(size)) return 0;
    std::memcpy(&size, head.data(), sizeof(size));
    write_pipe(picture(read_bytes(size), width));
  }
} catch (const std::bad_alloc&) {
  return kOutOfMemoryCode;
} catch (...) {
  return kFailureCode;
}

std::vector<std::string> decoder_command(const ParserLimits& limits, int width) {
  return {reader_program(), std::to_string(limits.memory), std::to_string(limits.seconds),
          "pictures", std::to_string(width)};
}

std::vector<std::string> reader_command(const ParserLimits& limits, const LogRequest& request,
                                        const std::vector<std::string>& libraries) {
  std::vector<std::string> command{reader_program()};
  command.push_back(std::to_string(limits.memory));
  command.push_back(std::to_string(limits.seconds));
  command.emplace_back(request.points ? "points" : "no-points");
  for (const std::string& name : request.classes) command.push_back("class=" + name);
  for (const std::string& library : libraries) {
    command.push_back("library=" + std::filesystem::absolute(library).string());
  }
  return command;
}

int run_rawlog_reader(const std::vector<std::string>& command) {
  constexpr std::size_t kFixed = 4;
  constexpr std::string_view kClass = "class=", kLibrary = "library=";
  if (command.size() < kFixed) return kFailureCode;
  const ParserLimits limits{std::stoull(command[1]), std::stoull(command[2])};
  if (command[3] == "pictures" && command.size() > kFixed) {
    return decode_pictures(limits, std::stoi(command[kFixed]));
  }
  LogRequest request;
  request.points = command[3] == "points";
  for (std::size_t i = kFixed; i < command.size(); ++i) {
    const std::string_view word = command[i];
    if (word.substr(0, kClass.size()) == kClass) {
      request.classes.emplace_back(word.substr(kClass.size()));
    } else if (word.substr(0, kLibrary.size()) == kLibrary) {
      ::dlopen(command[i].c_str() + kLibrary.size(), RTLD_NOW | RTLD_GLOBAL);
    }
  }
  return parse_into_pipe(limits, request);
}

}  // namespace hybrid
