// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/command_line.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <vector>

#include "apps/help_formatter.h"
#include "apps/program.h"
#include "apps/version.h"
#include "libhybrid/io/escaped.h"
#include "mrpt_plugins/bridge/ini_file.h"

namespace hybrid {
namespace {

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  return names;
}

std::string suggestion(const std::string& word, const std::vector<std::string>& known) {
  const std::string nearest = nearest_name(word, known);
  return nearest.empty() ? "" : fmt::format("; did you mean {}?", nearest);
}

/// Error message for the first unknown word of the command line, or "".
std::string unknown_word(const CLI::App& app) {
  const CLI::App* command = &app;
  for (const CLI::App* parsed : app.get_subcommands()) command = parsed;
  const std::vector<std::string> words = app.remaining(true);
  for (const std::string& word : words) {
    if (word.size() < 2 || word[0] != '-') continue;
    const std::string name = word.substr(0, word.find('='));
    return fmt::format("there is no option {}{}", escaped(name),
                       suggestion(name, option_names(*command)));
  }
  if (words.empty()) return "";
  const std::vector<std::string> commands = command_names(*command);
  if (commands.empty()) return in_quotes(words.front()) + " is one argument too many";
  return fmt::format("there is no {}{}; known are: {}", in_quotes(words.front()),
                     suggestion(words.front(), commands), fmt::join(commands, " "));
}

int complain_of(const CLI::App& app, const CLI::ParseError& error) {
  std::string what = unknown_word(app);
  if (what.empty()) what = error.what();
  const std::vector<std::string> commands = command_names(app);
  if (what == error.what() && !commands.empty() && app.get_subcommands().empty()) {
    what = fmt::format("one of these must be named: {}", fmt::join(commands, " "));
  }
  complain("{}: {}\nRun with --help for more information.\n", app.get_name(), what);
  return kExitFailure;
}

/// Lets --help of the program and of its commands be laid out alike.
void lay_out_help(CLI::App& app, const std::shared_ptr<HelpFormatter>& formatter) {
  app.formatter(formatter);
  app.get_help_ptr()->description("print this text and exit");
  for (CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    lay_out_help(*command, formatter);
  }
}

}  // namespace

void add_settings(CLI::App& app, std::vector<std::string>& settings) {
  app.add_option("--set", settings,
                 "a value instead of that in the INI; may be given several times")
      ->type_name("SECTION.KEY=VALUE")
      ->allow_extra_args(false);
}

void add_output_folder(CLI::App& app, std::string& output) {
  app.add_option("-o,--output", output, "folder for the results, created if absent")
      ->type_name("OUT")
      ->capture_default_str();
}

std::string fault_of_file_name(const std::string& name) {
  return name.empty() ? "names no file" : "";
}

void add_picture_format(CLI::App& app, PictureFormat& format) {
  const auto take = [&format](const std::string& name) { format = picture_format(name); };
  app.add_option_function<std::string>(
         "--picture-format", take,
         "of the pictures in the plane: png, or lines and texts as svg or pdf, for papers")
      ->type_name("FORMAT")
      ->check(CLI::IsMember({"png", "svg", "pdf"}));
}

void add_retired_flag(CLI::App& app, const std::string& name) {
  app.add_flag_callback(name,
                        [program = app.get_name(), name] {
                          complain("{}: warning: {} is retired and has no effect\n", program, name);
                        })
      ->group("");
}

bool parse_command_line(CLI::App& app, int argc, char** argv, int& exit_code) {
  app.set_version_flag("--version", app.get_name() + " " + program_version(),
                       "print the version and exit");
  lay_out_help(app, std::make_shared<HelpFormatter>(help_width()));
  try {
    app.parse(argc, argv);
    return true;
  } catch (const CLI::ParseError& e) {
    const bool is_asked_for = e.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success);
    exit_code = is_asked_for ? app.exit(e) : complain_of(app, e);
    return false;
  }
}

Provenance provenance_of(int argc, char** argv) {
  Provenance provenance;
  provenance.version = program_version();
  provenance.command.assign(argv, argv + argc);
  return provenance;
}

}  // namespace hybrid
