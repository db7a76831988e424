// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/locate/params.h"

#include "support/matchers.h"
#include "support/temp_dir.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <set>
#include <sstream>

namespace planar_bin_picking {
namespace {

std::string text(double value) {
  std::ostringstream out;
  out.precision(17);
  out << value;
  return out.str();
}

/// All values as YAML, nested as in config/locator.yaml.
std::string toYaml(const LocatorParams& params) {
  std::map<std::string, std::string> stages;
  std::string top;
  forEachField(params, [&](const std::string& key, const auto& value, auto, auto) {
    using Value = std::decay_t<decltype(value)>;
    const std::string shown =
        std::is_same<Value, bool>::value ? (value ? "true" : "false") : text(value);
    const std::size_t slash = key.find('/');
    if (slash == std::string::npos) {
      top += key + ": " + shown + "\n";
    } else {
      stages[key.substr(0, slash)] += "  " + key.substr(slash + 1) + ": " + shown + "\n";
    }
  });
  for (const auto& [stage, lines] : stages) top += stage + ":\n" + lines;
  return top;
}

/// The value of every field, as a number.
std::map<std::string, double> valuesOf(const LocatorParams& params) {
  std::map<std::string, double> values;
  forEachField(params, [&](const std::string& key, const auto& value, auto, auto) {
    values[key] = static_cast<double>(value);
  });
  return values;
}

/// All fields at the lower or the upper end of their ranges.
LocatorParams atEnd(bool upper) {
  LocatorParams params;
  forEachField(params, [upper](const std::string&, auto& value, auto min, auto max) {
    value = static_cast<std::decay_t<decltype(value)>>(upper ? max : min);
  });
  return params;
}

TEST(Params, DefaultsAreValidAndKeysUnique) {
  EXPECT_NO_THROW(validate(LocatorParams()));
  const LocatorParams params;
  std::set<std::string> keys;
  forEachField(params, [&](const std::string& key, const auto&, auto min, auto max) {
    EXPECT_TRUE(keys.insert(key).second) << key;
    EXPECT_LE(min, max) << key;
  });
  EXPECT_FALSE(keys.empty());
}

TEST(Params, EndsOfRangesAreValid) {
  EXPECT_NO_THROW(validate(atEnd(false)));
  EXPECT_NO_THROW(validate(atEnd(true)));
}

TEST(Params, EachFieldIsRefusedBeyondItsRangeByName) {
  LocatorParams params;
  forEachField(params, [&](const std::string& key, auto& value, auto min, auto max) {
    using Value = std::decay_t<decltype(value)>;
    if (std::is_same<Value, bool>::value) return;
    const Value before = value;
    value = static_cast<Value>(max + 1);
    EXPECT_TRUE(refuses([&] { validate(params); }, {key + " is "}));
    value = static_cast<Value>(min - 1);
    EXPECT_TRUE(refuses([&] { validate(params); }, {key + " is "}));
    if (std::numeric_limits<Value>::has_quiet_NaN) {
      value = std::numeric_limits<Value>::quiet_NaN();
      EXPECT_TRUE(refuses([&] { validate(params); }, {key + " is "}));
    }
    value = before;
  });
}

class LoadParams : public testing::Test {
 protected:
  LocatorParams load(const std::string& yaml) {
    return loadLocatorParams(dir_.write("locator.yaml", yaml));
  }
  testing::AssertionResult refused(const std::string& yaml, std::vector<std::string> words) {
    words.push_back("locator.yaml");
    return refuses([&] { load(yaml); }, words);
  }
  TempDir dir_;
};

TEST_F(LoadParams, ReadsBackWhatIsWritten) {
  for (const LocatorParams& params : {LocatorParams(), atEnd(false), atEnd(true)}) {
    EXPECT_EQ(valuesOf(load(toYaml(params))), valuesOf(params));
  }
}

TEST_F(LoadParams, KeepsDefaultsOfWhatIsNotWritten) {
  EXPECT_EQ(valuesOf(load("{}")), valuesOf(LocatorParams()));
  EXPECT_EQ(valuesOf(load("score:\n  # threshold: 0.7\n")), valuesOf(LocatorParams()));
  std::map<std::string, double> expected = valuesOf(LocatorParams());
  expected["score/threshold"] = 0.625;
  EXPECT_EQ(valuesOf(load("score: {threshold: 0.625}\n")), expected);
}

TEST_F(LoadParams, RefusesWhatStandsWithinItself) {
  EXPECT_TRUE(refused("score: &it {threshold: *it}\n", {"alias"}));
}

TEST_F(LoadParams, NamesTheKeyOfWhatIsWrong) {
  EXPECT_TRUE(
      refused("score:\n  treshold: 0.7\n", {"unknown key", "score/treshold", "score/threshold"}));
  EXPECT_TRUE(refused("scores:\n  threshold: 0.7\n", {"unknown key", "scores/threshold"}));
  EXPECT_TRUE(refused("score:\n  threshold: high\n", {"score/threshold", "high", "a number"}));
  EXPECT_TRUE(refused("score:\n  threshold: 1.5\n", {"score/threshold", "1.5", "between 0 and 1"}));
  EXPECT_TRUE(refused("score:\n  threshold: .nan\n", {"score/threshold", "nan"}));
  EXPECT_TRUE(refused("score:\n  threshold:\n", {"score/threshold", "empty"}));
  EXPECT_TRUE(refused("score:\n  threshold: [0.5]\n", {"score/threshold", "[0.5]"}));
  EXPECT_TRUE(refused("threads: 1.5\n", {"threads", "1.5", "a whole number"}));
  EXPECT_TRUE(refused("threads: -1\n", {"threads", "-1"}));
  EXPECT_TRUE(refused("threads: 1\nthreads: 2\n", {"threads", "twice"}));
  EXPECT_TRUE(refused("score: 0.7\n", {"unknown key", "score"}));
}

TEST_F(LoadParams, RefusesOtherFiles) {
  EXPECT_TRUE(
      refuses([&] { loadLocatorParams(dir_.path("none.yaml")); }, {"none.yaml", "cannot be read"}));
  EXPECT_TRUE(refused("score: {threshold: 0.7\n", {"not valid YAML"}));
}

}  // namespace
}  // namespace planar_bin_picking
