// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <string>

namespace hybrid {

/// A program of the build with a pipe as standard input and output; standard error goes to a file.
class PipedProgram {
 public:
  PipedProgram(const std::string& command, const std::string& error_file) {
    std::array<int, 2> in{}, out{};
    EXPECT_EQ(::pipe(in.data()), 0);
    EXPECT_EQ(::pipe(out.data()), 0);
    const std::string shell =
        "exec " HYBRID_BINARY_DIR "/bin/" + command + " 2>'" + error_file + "'";
    process_ = ::fork();
    if (process_ == 0) {
      ::dup2(in[0], STDIN_FILENO);
      ::dup2(out[1], STDOUT_FILENO);
      for (const int end : {in[0], in[1], out[0], out[1]}) ::close(end);
      ::execl("/bin/sh", "sh", "-c", shell.c_str(), nullptr);
      ::_exit(127);
    }
    ::close(in[0]);
    ::close(out[1]);
    input_ = in[1];
    output_ = out[0];
  }
  ~PipedProgram() {
    wait();
    ::close(output_);
  }
  PipedProgram(const PipedProgram&) = delete;
  PipedProgram& operator=(const PipedProgram&) = delete;

  void write(const std::string& bytes) const {
    for (std::size_t done = 0; done < bytes.size();) {
      const ssize_t put = ::write(input_, bytes.data() + done, bytes.size() - done);
      ASSERT_GT(put, 0);
      done += static_cast<std::size_t>(put);
    }
  }
  void end_input() {
    if (input_ >= 0) ::close(input_);
    input_ = -1;
  }
  void signal(int number) const { ::kill(process_, number); }

  /// The next line of its output, without its end; "" at the end of all, or where none has come
  /// after a minute.
  std::string line() {
    constexpr int kPatience = 60'000;  // ms
    std::size_t end = 0;
    while ((end = read_.find('\n')) == std::string::npos) {
      pollfd polled{output_, POLLIN, 0};
      std::array<char, 4096> buffer{};
      if (::poll(&polled, 1, kPatience) <= 0) return "";
      const ssize_t got = ::read(output_, buffer.data(), buffer.size());
      if (got <= 0) return "";
      read_.append(buffer.data(), static_cast<std::size_t>(got));
    }
    std::string line = read_.substr(0, end);
    read_.erase(0, end + 1);
    return line;
  }

  /// Ends its input and returns its exit code, or 128 + signal if it crashed.
  int wait() {
    end_input();
    if (process_ < 0) return code_;
    while (!line().empty()) {
    }
    int status = 0;
    ::waitpid(process_, &status, 0);
    process_ = -1;
    return code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

 private:
  pid_t process_ = -1;
  int input_ = -1, output_ = -1, code_ = -1;
  std::string read_;  // and not given as a line yet
};

}  // namespace hybrid
