// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/help_formatter.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <regex>
#include <sstream>

namespace hybrid {
namespace {

constexpr std::size_t kWidest = 100;
constexpr std::size_t kNarrowest = 60;
constexpr std::size_t kColumn = 30;  // where the meaning of an option begins

/// The words of `text` after `start`, filled up to `width`; further lines are indented.
std::string filled(std::string start, const std::string& text, std::size_t indent,
                   std::size_t width) {
  const std::string gap(indent, ' ');
  std::string line = std::move(start);
  std::string out;
  bool is_fresh = true;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (!is_fresh && line.size() + 1 + word.size() > width) {
      out += line + '\n';
      line = gap;
      is_fresh = true;
    }
    for (; indent + word.size() > width; word.erase(0, width - line.size())) {
      out += line + word.substr(0, width - line.size()) + '\n';
      line = gap;
    }
    line += (is_fresh ? "" : " ") + word;
    is_fresh = false;
  }
  return out + line + '\n';
}

/// An indented line; where it is too long, it goes on below its last column.
std::string indented_line(const std::string& line, std::size_t width) {
  if (line.size() <= width) return line + '\n';
  std::size_t column = line.find_first_not_of(' ');
  const std::size_t gap = line.find("  ", column);
  if (gap < width / 2) column = line.find_first_not_of(' ', gap);
  return filled(line.substr(0, column), line.substr(column), column, width);
}

std::string filled_paragraphs(const std::string& text, std::size_t width) {
  std::string out, paragraph;
  const auto end_paragraph = [&] {
    if (!paragraph.empty()) out += filled("", paragraph, 0, width);
    paragraph.clear();
  };
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty() && line[0] != ' ') {
      paragraph += line + ' ';
      continue;
    }
    end_paragraph();
    out += indented_line(line, width);
  }
  end_paragraph();
  return out;
}

/// The name of the value of an option, such as " FILE..."; "" for a flag.
std::string value_name(const CLI::Option& option) {
  if (option.get_type_size() == 0) return "";
  const std::string typed = option.get_type_name();
  std::string name = typed.substr(0, typed.find(':'));  // what its validators say follows
  if (name == "FLOAT") name = "NUMBER";
  if (name == "INT" || name == "UINT") name = "N";
  return ' ' + name + (option.get_expected_max() > 1 ? "..." : "");
}

/// What the validators of an option let pass: "one of: a b", "1 to 5".
std::string allowed(const CLI::Option& option) {
  const std::string typed = option.get_type_name();
  std::smatch match;
  if (std::regex_search(typed, match, std::regex(R"(:\{(.*)\})"))) {
    return "one of: " + std::regex_replace(match[1].str(), std::regex(","), " ");
  }
  if (!std::regex_search(typed, match, std::regex(R"( in \[(\S+) - (\S+)\])"))) {
    return typed.find(":NONNEGATIVE") == std::string::npos ? "" : "0 or more";
  }
  if (std::stod(match[2]) >= 1e300) return match[1].str() + " or more";
  return match[1].str() + " to " + match[2].str();
}

std::string meaning_of(const CLI::Option& option) {
  std::vector<std::string> notes;
  if (option.get_required()) notes.emplace_back("required");
  const std::string values = allowed(option);
  if (!values.empty()) notes.push_back(values);
  std::string standard = option.get_default_str();
  if (standard.size() > 1 && standard.front() == '[')
    standard = standard.substr(1, standard.size() - 2);
  if (!standard.empty() && option.get_type_size() != 0) notes.push_back("default " + standard);
  for (const CLI::Option* other : option.get_excludes()) {
    notes.push_back("not with " + other->get_name());
  }
  if (notes.empty()) return option.get_description();
  return fmt::format("{} ({})", option.get_description(), fmt::join(notes, "; "));
}

}  // namespace

std::size_t help_width() {
  winsize terminal{};
  if (isatty(STDOUT_FILENO) == 0 || ioctl(STDOUT_FILENO, TIOCGWINSZ, &terminal) != 0 ||
      terminal.ws_col == 0) {
    return kWidest;
  }
  return std::clamp<std::size_t>(terminal.ws_col, kNarrowest, kWidest);
}

std::string HelpFormatter::make_help(const CLI::App* app, std::string name,
                                     CLI::AppFormatMode mode) const {
  const std::string text = Formatter::make_help(app, std::move(name), mode);
  return std::regex_replace(text, std::regex("\n{3,}"), "\n\n");
}

std::string HelpFormatter::make_description(const CLI::App* app) const {
  return filled_paragraphs(app->get_description(), width_) + '\n';
}

std::string HelpFormatter::make_footer(const CLI::App* app) const {
  return filled_paragraphs(app->get_footer(), width_);
}

std::string HelpFormatter::make_subcommand(const CLI::App* command) const {
  return row(command->get_name(), command->get_description());
}

std::string HelpFormatter::make_option(const CLI::Option* option, bool is_positional) const {
  if (is_positional) {
    const bool is_list = option->get_expected_max() > 1;
    return row(option->get_name(true) + (is_list ? "..." : ""), meaning_of(*option));
  }
  std::vector<std::string> names;
  for (const std::string& name : option->get_snames()) names.push_back('-' + name);
  for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return row(fmt::format("{}{}", fmt::join(names, ", "), value_name(*option)), meaning_of(*option));
}

std::string HelpFormatter::make_option_usage(const CLI::Option* option) const {
  const std::string name = option->get_name(true) + (option->get_expected_max() > 1 ? "..." : "");
  return option->get_required() ? name : '[' + name + ']';
}

std::string HelpFormatter::row(const std::string& name, const std::string& meaning) const {
  std::string start = "  " + name;
  std::string out;
  if (start.size() + 2 > kColumn) {
    out = start + '\n';
    start.clear();
  }
  start.resize(kColumn, ' ');
  return out + filled(start, meaning, kColumn, width_);
}

}  // namespace hybrid
