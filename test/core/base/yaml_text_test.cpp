// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "base/yaml_text.h"

#include "support/comma_locale.h"

#include <gtest/gtest.h>

#include <yaml-cpp/yaml.h>

namespace planar_bin_picking {
namespace {

/// Whatever a file or a layer is called comes back as that text, on one line.
TEST(YamlText, ComesBackAsItWas) {
  for (const std::string text :
       {"bracket", "12",    "1.5",           "true", "No",         "null",  "~",
        "",        " a ",   "it's",          "a: b", "[x]",        "#1",    "Ma\u00dfe",
        "a\nb",    "tab\t", "\"quoted\" \\", "- x",  "left-2.b@3", "a'\nb", "\u2028x"}) {
    const std::string yaml = yamlText(text);
    EXPECT_EQ(yaml.find('\n'), std::string::npos);
    const YAML::Node node = YAML::Load("[" + yaml + "]");
    EXPECT_EQ(node[0].as<std::string>(), text) << yaml;
  }
  EXPECT_EQ(yamlText("bracket_2-a"), "bracket_2-a");
  EXPECT_EQ(yamlText("12"), "'12'");
  EXPECT_EQ(yamlText("Yes"), "'Yes'");
  // Bytes of an unknown code page; the half of a character at the end.
  EXPECT_EQ(yamlText("Ma\xDF"), "\"Ma\\xDF\"");
  EXPECT_EQ(yamlText("\xC0\x80 \xED\xA0\x80 \xE2\x80"),
            "\"\\xC0\\x80 \\xED\\xA0\\x80 \\xE2\\x80\"");
}

TEST(YamlText, NumbersHaveTheirPointInEveryLocale) {
  EXPECT_EQ(yamlNumber(1234567.891, 2), "1234567.89");
  const CommaLocale commas;
  EXPECT_EQ(yamlNumber(1234567.891, 2), "1234567.89");
  EXPECT_EQ(yamlList({1000.5, -0.25}, 3), "[1000.500, -0.250]");
}

TEST(YamlText, ListsQuoteWhatNeedsIt) {
  EXPECT_EQ(yamlList(std::vector<std::string>{}), "[]");
  EXPECT_EQ(yamlList(std::vector<std::string>{"a", "b, c"}), "[a, 'b, c']");
}

}  // namespace
}  // namespace planar_bin_picking
