// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/bridge/read_options.h"

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "libhybrid/detections/class_model.h"
#include "libhybrid/initialization/gaussian_sum_initializer.h"
#include "libhybrid/landmarks/association_options.h"
#include "libhybrid/online/online_selection.h"
#include "libhybrid/smoother/window_options.h"
#include "libhybrid/solvers/alternating.h"

namespace hybrid {
namespace {

struct Toy {
  enum class Colour { kRed, kGreen };
  static constexpr Named<Colour> kColours[] = {{"red", Colour::kRed}, {"green", Colour::kGreen}};
  Colour colour = Colour::kGreen;
  double gate = 0.9;
  std::vector<double> extent = {1, 2};
  int inner = 3;

  template <class Table>
  static void describe(Table& table) {
    table.choice("colour", &Toy::colour, "of the toy", kColours);
    table.option("gate", &Toy::gate, kProbability, "of its garden", "garden_gate");
    table.option("extent", &Toy::extent, "of it [m]");
    table.field("inner", &Toy::inner, "not in files");
  }
};

Toy read_toy(IniFile& ini) {
  IniSection section = ini.section("toy");
  Toy toy;
  read_options(section, toy);
  ini.reject_unknown();
  return toy;
}

/// What is said of a file that is refused.
std::string refusal_of_toy(const std::string& keys) {
  IniFile ini("[toy]\n" + keys, "test.ini");
  try {
    read_toy(ini);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(ReadOptions, EveryOptionIsReadByItsKey) {
  IniFile ini("[toy]\ncolour = Red\ngarden_gate = 0.5\nextent = 3\n", "test.ini");
  const Toy toy = read_toy(ini);
  EXPECT_EQ(toy.colour, Toy::Colour::kRed);
  EXPECT_EQ(toy.gate, 0.5);
  EXPECT_EQ(toy.extent, std::vector<double>{3});
}

TEST(ReadOptions, WithoutKeysTheValuesStay) {
  IniFile ini;
  const Toy toy = read_toy(ini);
  EXPECT_EQ(toy.colour, Toy::Colour::kGreen);
  EXPECT_EQ(toy.gate, 0.9);
  EXPECT_EQ(ini.documentation(),
            "[toy]\n# of the toy (one of: red green; default green)\ncolour = green\n"
            "# of its garden (number, >= 0, <= 1; default 0.9)\ngarden_gate = 0.9\n"
            "# of it [m] (list of numbers; default 1 2)\nextent = 1 2\n\n");
}

TEST(ReadOptions, WhatIsNoOptionOfFilesIsRefused) {
  EXPECT_EQ(refusal_of_toy("gate = 0.5\n").find("test.ini:2:1: [toy] has no key 'gate'"), 0U);
  EXPECT_EQ(refusal_of_toy("inner = 4\n").find("test.ini:2:1: [toy] has no key 'inner'"), 0U);
  EXPECT_EQ(refusal_of_toy("garden_gate = 2\n").find("test.ini:2:1: [toy] garden_gate = '2'"), 0U);
  EXPECT_EQ(refusal_of_toy("colour = blue\n").find("test.ini:2:1: [toy] colour = 'blue'"), 0U);
}

TEST(ReadOptions, OneOptionAlone) {
  IniFile ini("[toy]\ngarden_gate = 0.5\nextent = 3\n", "test.ini");
  IniSection section = ini.section("toy");
  Toy toy;
  read_option(section, toy, "gate", "for once: ");
  EXPECT_EQ(toy.gate, 0.5);
  EXPECT_EQ(toy.extent.size(), 2U);
  EXPECT_NE(ini.documentation().find("# for once: of its garden"), std::string::npos);
  EXPECT_THROW(read_option(section, toy, "garden_gate"), Error);
}

/// Looks at what a struct tells of its options.
template <class T>
class DescribedOptions : public testing::Test {
 public:
  template <class Member, class Owner>
  void field(const char* name, Member Owner::*, const std::string& meaning) {
    EXPECT_TRUE(names.insert(name).second) << name << " twice";
    EXPECT_TRUE(!meaning.empty() && meaning.back() != '.') << name;
  }
  template <class Member, class Owner>
  void option(const char* name, Member Owner::*member, const char* meaning) {
    option(name, member, kAnyNumber, meaning);
  }
  template <class Member, class Owner>
  void option(const char* name, Member Owner::*member, const Interval& interval,
              const char* meaning, const char* key = nullptr) {
    field(name, member, meaning);
    EXPECT_TRUE(keys.insert(key != nullptr ? key : name).second) << name << ": its key twice";
    if constexpr (std::is_arithmetic_v<Member>) {
      EXPECT_TRUE(interval.contains(static_cast<double>(defaults.*member))) << name;
    }
  }
  template <class Member, class Owner, class Choices>
  void choice(const char* name, Member Owner::*member, const char* meaning, const Choices&) {
    field(name, member, meaning);
  }

  T defaults;
  std::set<std::string> names, keys;
};

using EveryStruct =
    testing::Types<AlternatingOptions, AssociationOptions, BankOptions, ClassOptions,
                   ClosureSelectionOptions, MixtureOptions, OnlineSelectionOptions, SmootherOptions,
                   SolverOptions, WindowOptions>;
TYPED_TEST_SUITE(DescribedOptions, EveryStruct);

TYPED_TEST(DescribedOptions, NamesDifferAndIntervalsHoldTheDefaults) {
  TypeParam::describe(*this);
  EXPECT_FALSE(this->names.empty());
}

}  // namespace
}  // namespace hybrid
