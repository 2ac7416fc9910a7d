// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace hybrid {

/// Columns for the text of --help: those of the terminal that it goes to, from 60 to 100; 100 where
/// it goes elsewhere, as to a manual page.
std::size_t help_width();

/// Lays out --help: no line is longer than `width`, and what is said of an option begins in one
/// column for all. Values, range and default of an option stand in brackets behind its meaning. Of
/// descriptions and footers, lines without indentation are paragraphs, which are filled anew;
/// indented ones stay lines, and go on below their last column where they are too long.
class HelpFormatter : public CLI::Formatter {
 public:
  explicit HelpFormatter(std::size_t width) : width_(width) {}

  std::string make_help(const CLI::App* app, std::string name,
                        CLI::AppFormatMode mode) const override;
  std::string make_description(const CLI::App* app) const override;
  std::string make_footer(const CLI::App* app) const override;
  std::string make_subcommand(const CLI::App* command) const override;
  std::string make_option(const CLI::Option* option, bool is_positional) const override;
  std::string make_option_usage(const CLI::Option* option) const override;

 private:
  std::string row(const std::string& name, const std::string& meaning) const;

  std::size_t width_;
};

}  // namespace hybrid
