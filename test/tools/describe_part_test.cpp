// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

// The program itself, as a user runs it.

#include "support/dxf_writer.h"
#include "support/slow.h"
#include "support/tool_test.h"

#include <sys/resource.h>
#include <yaml-cpp/yaml.h>

namespace planar_bin_picking {
namespace {

/// Of processors, so that what else runs on the machine does not count.
double secondsOfChildren() {
  rusage usage = {};
  getrusage(RUSAGE_CHILDREN, &usage);
  return usage.ru_utime.tv_sec + 1e-6 * usage.ru_utime.tv_usec + usage.ru_stime.tv_sec +
         1e-6 * usage.ru_stime.tv_usec;
}

class DescribePart : public ToolTest {
 protected:
  DescribePart() : ToolTest(DESCRIBE_PART) {}

  /// 90 x 60 mm with two holes and a print.
  std::string plate(const std::string& name) {
    DxfWriter dxf;
    dxf.rectangle(0, 0, 90, 60).circle(20, 20, 4).circle(70, 40, 6);
    dxf.line(30, 30, 40, 30, "PRINT").line(0, 0, 3, 3, "TITLE");
    return dir_.write(name, dxf.text());
  }
};

TEST_F(DescribePart, PrintsWhatWasRead) {
  plate("plate.dxf");
  const std::string yaml = dir_.write(
      "plate.yaml",
      "drawing: plate.dxf\npick_poses:\n"
      "  - {name: suction, face: front, position_mm: [40, 30, 0], rpy_deg: [180, 0, 0]}\n"
      "  - {name: suction_back, face: back, position_mm: [40, 30, 0]}\n");
  ASSERT_EQ(run(yaml), 0) << error_;
  EXPECT_EQ(error_, "");
  const YAML::Node root = YAML::Load(out_);
  std::string keys;
  for (const auto& entry : root) keys += entry.first.Scalar() + " ";
  EXPECT_EQ(keys,
            "part units size_mm area_mm2 holes prints symmetry_order mirror_symmetric pick_poses "
            "left_out warnings ");
  EXPECT_EQ(root["part"].as<std::string>(), "plate");
  EXPECT_NEAR(root["size_mm"][0].as<double>(), 90.0, 1e-3);
  EXPECT_NEAR(root["size_mm"][1].as<double>(), 60.0, 1e-3);
  EXPECT_NEAR(root["area_mm2"].as<double>(), 90 * 60 - 3.14159 * (16 + 36), 2.0);
  EXPECT_EQ(root["holes"].as<int>(), 2);
  EXPECT_EQ(root["prints"].as<int>(), 1);
  EXPECT_EQ(root["symmetry_order"].as<int>(), 1);
  EXPECT_FALSE(root["mirror_symmetric"].as<bool>());
  EXPECT_EQ(root["pick_poses"].as<std::vector<std::string>>(),
            (std::vector<std::string>{"suction", "suction_back"}));
  EXPECT_TRUE(root["left_out"].IsSequence());
  EXPECT_TRUE(root["warnings"].IsSequence());
}

TEST_F(DescribePart, ShowsUnitsWhatWasLeftOutAndWarnings) {
  plate("plate.dxf");
  const std::string yaml = dir_.write("plate.yaml",
                                      "drawing: plate.dxf\nunits: inch\npick_poses:\n"
                                      "  - {name: far, face: back, position_mm: [-100, 0, 0]}\n");
  ASSERT_EQ(run(yaml), 0) << error_;
  const YAML::Node root = YAML::Load(out_);
  EXPECT_EQ(root["units"].as<std::string>(), "inch");
  EXPECT_NEAR(root["size_mm"][0].as<double>(), 25.4 * 90.0, 1e-3);
  EXPECT_EQ(root["left_out"].as<std::vector<std::string>>(),
            std::vector<std::string>{"layer TITLE: 1 entity"});
  bool warned = false;
  for (const YAML::Node& warning : root["warnings"])
    warned = warned || warning.as<std::string>().find("pick pose far") == 0;
  EXPECT_TRUE(warned) << out_;
  for (const auto& [units, mm] :
       {std::pair{"mm", 1.0}, {"cm", 10.0}, {"m", 1000.0}, {"inch", 25.4}}) {
    dir_.write("small.dxf", DxfWriter(-1).rectangle(0, 0, 2, 1).text());
    ASSERT_EQ(run(dir_.write("small.yaml", std::string("drawing: small.dxf\nunits: ") + units)), 0)
        << error_;
    EXPECT_NEAR(YAML::Load(out_)["size_mm"][0].as<double>(), 2.0 * mm, 1e-3) << units;
    EXPECT_EQ(YAML::Load(out_)["units"].as<std::string>(), units);
  }
}

TEST_F(DescribePart, DescribesTheOthersWhereOneIsRefused) {
  const std::string good = plate("good.dxf"), also = plate("also.dxf");
  const std::string bad = dir_.write("bad.dxf", DxfWriter().line(0, 0, 9, 9).text());
  EXPECT_EQ(run(good + " " + bad + " " + dir_.path("none.dxf") + " " + also), 2);
  EXPECT_EQ(std::count(error_.begin(), error_.end(), '\n'), 2) << error_;
  EXPECT_NE(error_.find("describe_part: " + bad + ": open contour"), std::string::npos) << error_;
  EXPECT_NE(error_.find("none.dxf: does not exist"), std::string::npos) << error_;
  const std::vector<YAML::Node> documents = YAML::LoadAll(out_);
  ASSERT_EQ(documents.size(), 2u);
  EXPECT_EQ(documents[0]["part"].as<std::string>(), "good");
  EXPECT_EQ(documents[1]["part"].as<std::string>(), "also");
}

TEST_F(DescribePart, PrintsItsUsageAndRefusesWrongArguments) {
  EXPECT_TRUE(printsItsVersion(""));
  EXPECT_EQ(run("--help"), 0);
  EXPECT_NE(out_.find("PART"), std::string::npos);
  EXPECT_TRUE(refused("", {"PART is required", "--help"}));
  EXPECT_TRUE(refused("--parts x", {"not expected", "--parts"}));
  EXPECT_TRUE(refused("\"\"", {"path of a part is empty"}));
}

TEST_F(DescribePart, QuotesNamesThatAreNoWords) {
  plate("12.dxf");
  ASSERT_EQ(run(dir_.path("12.dxf")), 0) << error_;
  EXPECT_EQ(out_.find("part: '12'\n"), 0u) << out_;
}

TEST_F(DescribePart, ThousandsOfHolesTakeNoTime) {
  for (const auto& [across, seconds] : {std::pair{32, 0.5}, {55, 2.0}}) {  // 1024 and 3025 holes
    DxfWriter dxf;
    dxf.rectangle(0, 0, 4 * across, 4 * across);
    for (int i = 0; i < across * across; ++i)
      dxf.circle(2 + 4 * (i % across), 2 + 4 * (i / across), 1.5);
    const std::string path = dir_.write("sieve.dxf", dxf.text());
    const auto before = secondsOfChildren();
    ASSERT_EQ(run(path), 0) << error_;
    EXPECT_LT(secondsOfChildren() - before, kSlow * seconds) << across;
    EXPECT_NE(out_.find("holes: " + std::to_string(across * across)), std::string::npos) << out_;
    EXPECT_NE(out_.find("symmetry_order: 4\n"), std::string::npos) << out_;
  }
}

}  // namespace
}  // namespace planar_bin_picking
