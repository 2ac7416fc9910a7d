// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/bridge/ini_file.h"

#include <gtest/gtest.h>
#include <mrpt/config/CConfigFileMemory.h>

#include <filesystem>
#include <functional>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

std::string message_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& e) {
    return e.what();
  }
  return "(no error)";
}

void expect_error(const std::function<void()>& call, const std::vector<std::string>& parts) {
  const std::string message = message_of(call);
  for (const std::string& part : parts) {
    EXPECT_NE(message.find(part), std::string::npos) << "'" << part << "' not in: " << message;
  }
}

TEST(IniFile, ReadsTypedValues) {
  IniFile ini(
      "# comment\n[Solver]\niterations = 7 // seven\nstep = -1.5e-3 ; small\nfast = Yes\n"
      "name = two words # here\nlist = 1, 2.5 3\nmethod = LM\nurl = a//b\nangle = 180\n",
      "a.ini");
  IniSection s = ini.section("solver");
  EXPECT_EQ(s.get("ITERATIONS", 1, "n"), 7);
  EXPECT_DOUBLE_EQ(s.get("step", 1.0, "s"), -1.5e-3);
  EXPECT_TRUE(s.get("fast", false, "f"));
  EXPECT_EQ(s.get("name", "x", "n"), "two words");
  EXPECT_EQ(s.get("list", std::vector<double>{}, "l"), (std::vector<double>{1, 2.5, 3}));
  EXPECT_EQ(s.choice("method", "dogleg", {"lm", "dogleg"}, "m"), "lm");
  EXPECT_EQ(s.get("url", "", "u"), "a//b");
  EXPECT_DOUBLE_EQ(s.degrees("angle", 0, "a"), M_PI);
  EXPECT_EQ(s.get("absent", 42, "x"), 42);
  EXPECT_NO_THROW(ini.reject_unknown());
}

TEST(IniFile, RefusesWhatMrptLetsPass) {
  for (const char* value : {"abc", "3,5", "12abc", "", "nan", "inf", "1e999", "0x10"}) {
    IniFile ini(std::string("[a]\n\nx = ") + value + "\n", "b.ini");
    expect_error([&] { ini.section("a").get("x", 1.0, "x"); }, {"b.ini:3", "[a]", "x", "number"});
  }
  for (const char* value : {"maybe", "2", ""}) {
    IniFile ini(std::string("[a]\nx = ") + value + "\n", "b.ini");
    expect_error([&] { ini.section("a").get("x", true, "x"); },
                 {"b.ini:2", "[a]", "true or false"});
  }
  for (const char* value : {"1.5", "99999999999", "one", ""}) {
    IniFile ini(std::string("[a]\nx = ") + value + "\n", "b.ini");
    expect_error([&] { ini.section("a").get("x", 1, "x"); }, {"b.ini:2", "whole number"});
  }
  IniFile ini("[a]\nx = 1.5\ny = -1\nmethod = lmm\nu = -3", "b.ini");
  IniSection a = ini.section("a");
  expect_error([&] { a.get("x", 0.5, "x", kProbability); }, {"b.ini:2", "<= 1"});
  expect_error([&] { a.get("y", 0.5, "y", kPositive); }, {"b.ini:3", ">= 1e-09, <= 1000000000"});
  expect_error([&] { a.get("u", std::uint64_t{1}, "u"); }, {"b.ini:5", ">= 0"});
  expect_error(
      [&] {
        a.choice("method", "lm", {"lm", "dogleg"}, "");
      },
      {"b.ini:4", "did you mean 'lm'?"});
  expect_error([&] { a.require<int>("z", "z"); }, {"b.ini:1", "[a]", "z", "required"});
}

TEST(IniFile, RefusesMalformedLines) {
  expect_error([] { IniFile("[a\nx=1\n", "c.ini"); }, {"c.ini:1", "lacks its ']'"});
  expect_error([] { IniFile("[a]\nx 1\n", "c.ini"); }, {"c.ini:2", "x 1"});
  expect_error([] { IniFile("x = 1\n", "c.ini"); }, {"c.ini:1", "before the first [section]"});
  expect_error([] { IniFile("[a]\nx = 1\n[b]\n[A]\nX = 2\n", "c.ini"); },
               {"c.ini:5", "already set at c.ini:2"});
  expect_error([] { IniFile(std::filesystem::path("no/such.ini")); },
               {"no/such.ini: no such file"});
  expect_error([] { IniFile(std::filesystem::path("/")); }, {"/: is a folder, not a file"});
}

TEST(IniFile, RejectsUnknownNamesWithSuggestion) {
  IniFile ini("[solver]\niteratons = 3\n[calibraton]\nx = 1\n", "d.ini");
  ini.section("solver").get("iterations", 5, "");
  ini.section("calibration");
  expect_error([&] { ini.reject_unknown(); },
               {"d.ini:2:1: [solver] has no key 'iteratons'; did you mean 'iterations'?",
                "d.ini:3:1: unknown section [calibraton]; did you mean 'calibration'?"});
}

TEST(IniFile, AgreesWithMrptOnSyntax) {
  const std::string text =
      "# c\n; c2\n@define A 3\n[S] // comment\nx = ${A} // trailing\n"
      "a = 1 2 \\\n 3 4\nB = first\n[ spaced ]\nu = http://x/y\n[S]\nagain = 2\n";
  mrpt::config::CConfigFileMemory mrpt;
  mrpt.setContent(text);
  IniFile ini(text, "e.ini");
  std::vector<std::string> sections, keys;
  mrpt.getAllSections(sections);
  EXPECT_EQ(ini.sections().size(), sections.size());
  for (const std::string& section : sections) {
    mrpt.getAllKeys(section, keys);
    IniSection ours = ini.section(section);
    EXPECT_EQ(ours.keys().size(), keys.size()) << section;
    for (const std::string& key : keys) {
      EXPECT_EQ(ours.get(key, "", ""), mrpt.read_string(section, key, "?")) << key;
    }
  }
  // Line numbers survive the joined line.
  expect_error([&] { ini.section("S").get("again", true, ""); }, {"e.ini:12"});
}

// MRPT's parser would read the environment and run what stands in braces, which may not end.
TEST(IniFile, RunsNothingAndReadsNoEnvironment) {
  expect_error([] { IniFile("[a]\n x = $env{HOME}\n", "e.ini"); },
               {"e.ini:2:2: $env{} is not supported: write the value"});
  expect_error([] { IniFile("[a]\nx = $eval{while(true){}}\n", "e.ini"); },
               {"e.ini:2:1: $eval{} is not supported"});
  expect_error([] { IniFile("@define A $env{HOME}\n", "e.ini"); }, {"e.ini:1:1: $env{}"});
  IniFile ini("@define A $en\n[a]\nx = ${A}v{HOME}\ny = 5 $ ${ A }\n", "e.ini");
  EXPECT_EQ(ini.section("a").get("x", "", ""), "$env{HOME}");  // put in, not run
  EXPECT_EQ(ini.section("a").get("y", "", ""), "5 $ $en");
  expect_error([] { IniFile("[a]\nx = ${B}\n", "e.ini"); }, {"e.ini:2:1: ${B} is not defined"});
  expect_error([] { IniFile("@include b.ini\n", "e.ini"); }, {"e.ini:1:1: expected '@define"});
  std::string bomb = "@define A0 xxxxxxxx\n";
  for (int i = 1; i < 60; ++i) {
    const std::string before = "${A" + std::to_string(i - 1) + "}";
    bomb += "@define A" + std::to_string(i) + " " + before + before + "\n";
  }
  expect_error([&] { IniFile(bomb, "e.ini"); }, {"e.ini:15:1: a value of more than 65536 bytes"});
}

TEST(IniFile, HoldsTextOfBoundedSize) {
  IniFile windows("\xef\xbb\xbf[a]\r\nx = 1\r\n", "e.ini");
  EXPECT_EQ(windows.section("a").get("x", 0, ""), 1);
  expect_error([] { IniFile("[a]\nx = \x1b[31m\n", "e.ini"); }, {"e.ini:2:5: a control character"});
  expect_error([] { IniFile(std::string("[a]\nx = \0", 9), "e.ini"); }, {"e.ini:2:5: a NUL byte"});
  expect_error([] { IniFile("[a]\nx = 1 \\\n", "e.ini"); }, {"ends behind a backslash"});
  expect_error([] { IniFile("[a]\nx = 3,5\n", "e.ini").section("a").get("x", 1.0, ""); },
               {"e.ini:2:1", "'3,5'"});
}

// As many lines as fit into a file, in a time that does not grow with their square, and a message
// that can be read.
TEST(IniFile, RefusesManyUnknownNamesInFewWords) {
  std::string text = "[a]\nx = 1\n";
  for (int i = 0; i < 60000; ++i) text += "k" + std::to_string(i) + "=1\n";
  for (int i = 0; i < 60000; ++i) text += "[s" + std::to_string(i) + "]\n";
  IniFile ini(text, "many.ini");
  ini.section("a").get("x", 1, "");
  const std::string message = message_of([&] { ini.reject_unknown(); });
  EXPECT_NE(message.find("many.ini:3:1: [a] has no key 'k0'"), std::string::npos) << message;
  EXPECT_NE(message.find("\nand 119980 more like these"), std::string::npos) << message;
  EXPECT_LT(message.size(), 2000u);
}

TEST(IniFile, DocumentationIsAnIniWithTheValuesInEffect) {
  const auto read = [](IniFile& ini) {
    IniSection s = ini.section("sensor", "What the robot sees with");
    s.require<double>("range", "how far [m]", kPositive);
    s.get("names", std::vector<std::string>{"a", "b"}, "who");
    return s.get("rate", 0.1, "how often [Hz]", kNonNegative);
  };
  IniFile defaults;
  EXPECT_EQ(read(defaults), 0.1);
  const std::string text = defaults.documentation();
  EXPECT_NE(text.find("# What the robot sees with\n[sensor]\n"), std::string::npos) << text;
  EXPECT_NE(text.find("# how often [Hz] (number, >= 0, <= 1000000000; default 0.1)\nrate = 0.1\n"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("(number, >= 1e-09, <= 1000000000; required)"), std::string::npos) << text;

  IniFile given("[sensor]\nrange = 3\nrate = 0.25\n", "f.ini");
  read(given);
  IniFile again(given.documentation(), "again.ini");
  EXPECT_EQ(read(again), 0.25);
  EXPECT_EQ(again.documentation(), given.documentation());
}

TEST(IniFile, PathsAreRelativeToTheFileAndOverridesToTheCaller) {
  IniFile ini("[log]\nfile = ../rawlogs/a.rawlog\nabs = /x/y\n", "config/g.ini");
  EXPECT_EQ(ini.section("log").path("file", "", ""), "rawlogs/a.rawlog");
  EXPECT_EQ(ini.section("log").path("abs", "", ""), "/x/y");
  EXPECT_EQ(ini.section("log").path("standard_input", "-", ""), "-");
  ini.override_value("log", "file", "b.rawlog");
  EXPECT_EQ(ini.section("log").path("file", "", ""), "b.rawlog");
  ini.override_value("log", "n", "x");
  expect_error([&] { ini.section("log").get("n", 1, ""); }, {"command line: [log] n"});
}

TEST(IniFile, OldNamesCountUnderTheNewOneWithAWarning) {
  IniFile ini("[log]\n\nperiod = 0.5\ntitle = T\n[Frames]\ngather = yes\n", "old.ini");
  IniSection log = ini.section("log");
  EXPECT_EQ(log.get("title", "", "t"), "T");
  IniSection reader = ini.section("reader");
  reader.replaces("period", "period", "log");
  reader.replaces("absent", "was_absent", "log");
  EXPECT_EQ(reader.get("period", 0.1, "p"), 0.5);
  IniSection frames = ini.section("frames");
  frames.replaces("tracklets", "Gather");
  EXPECT_TRUE(frames.get("tracklets", false, "t"));
  EXPECT_NO_THROW(ini.reject_unknown());
  ASSERT_EQ(ini.warnings().size(), 2u);
  EXPECT_EQ(ini.warnings()[0], "old.ini:3:1: [log] period is now [reader] period");
  EXPECT_EQ(ini.warnings()[1], "old.ini:6:1: [Frames] gather is now [Frames] tracklets");
  EXPECT_EQ(ini.documentation().find("gather"), std::string::npos);
  EXPECT_FALSE(log.has("period"));
}

TEST(IniFile, NewNamesAloneWarnOfNothing) {
  IniFile ini("[frames]\ntracklets = yes\n", "new.ini");
  IniSection frames = ini.section("frames");
  frames.replaces("tracklets", "gather");
  EXPECT_TRUE(frames.get("tracklets", false, "t"));
  EXPECT_TRUE(ini.warnings().empty());
}

TEST(IniFile, AValueThatIsWrongNamesTheKeyAsItWasGiven) {
  IniFile ini("[log]\nperiod = soon\n", "old.ini");
  ini.section("log");
  IniSection reader = ini.section("reader");
  reader.replaces("period", "period", "log");
  expect_error([&] { reader.get("period", 0.1, "p"); },
               {"old.ini:2", "[reader] period (given as [log] period)", "'soon'"});
}

TEST(IniFile, OldAndNewNameTogetherAreAnError) {
  const char* text = "[f]\ngather = yes\ntracklets = no\n";
  IniFile both(text, "both.ini");
  expect_error([&] { both.section("f").replaces("tracklets", "gather"); },
               {"both.ini:3", "[f] tracklets is given twice", "[f] gather at both.ini:2"});
  IniFile twice("[f]\nx = 1\n", "twice.ini");
  twice.override_values({"f.gather=yes", "f.tracklets=no"});
  expect_error([&] { twice.section("f").replaces("tracklets", "gather"); },
               {"command line", "given twice"});
}

TEST(IniFile, TheCommandLineGoesBeforeTheFileWhateverTheName) {
  IniFile by_old("[f]\ntracklets = no\n", "a.ini");
  by_old.override_values({"f.gather=yes"});
  IniSection f = by_old.section("f");
  f.replaces("tracklets", "gather");
  EXPECT_TRUE(f.get("tracklets", false, "t"));
  EXPECT_EQ(by_old.warnings().size(), 1u);

  IniFile by_new("[f]\ngather = no\n", "b.ini");
  by_new.override_values({"f.tracklets=yes"});
  IniSection g = by_new.section("f");
  g.replaces("tracklets", "gather");
  EXPECT_TRUE(g.get("tracklets", false, "t"));
  EXPECT_EQ(by_new.warnings().size(), 1u);
  EXPECT_NO_THROW(by_new.reject_unknown());
}

TEST(IniFile, OverridesReplaceWhatStandsThere) {
  IniFile ini("[a]\nx = 1\ny = 2\nz = 3\n", "c.ini");
  ini.override_values({"A.X=4", "a.x=5", "b.w=6"});
  IniSection a = ini.section("a");
  EXPECT_EQ(a.get("x", 0, ""), 5);
  EXPECT_EQ(a.get("y", 0, ""), 2);
  EXPECT_EQ(a.get("z", 0, ""), 3);
  EXPECT_EQ(ini.section("b").get("w", 0, ""), 6);
  EXPECT_NO_THROW(ini.reject_unknown());
  for (const char* bad : {"a", "a.x", "=1", ".x=1", "a.=1", "a=1.5"}) {
    expect_error([&] { ini.override_values({bad}); }, {bad, "SECTION.KEY=VALUE"});
  }
}

}  // namespace
}  // namespace hybrid
