// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
/// Each key of a part file changes what is read of the part, as describe_part prints it, or the
/// pick poses that the node answers. The tool's height shows at a pick alone: test/ros.

#include "planar_bin_picking/part/part_model.h"
#include "support/dxf_writer.h"
#include "support/tool_test.h"

#include <yaml-cpp/yaml.h>

namespace planar_bin_picking {
namespace {

class PartKeys : public ToolTest {
 protected:
  PartKeys() : ToolTest(DESCRIBE_PART) {}

  void SetUp() override {
    DxfWriter plate;
    plate.rectangle(0, 0, 90, 60).circle(20, 20, 4).circle(70, 40, 6, "BORE");
    plate.line(30, 30, 40, 30, "INK");
    dir_.write("plate.dxf", plate.text());
    dir_.write("other.dxf", DxfWriter().rectangle(0, 0, 80, 50).text());
    // A corner is open by 0.2 mm.
    dir_.write("gap.dxf", DxfWriter()
                              .line(0, 0, 90, 0)
                              .line(90, 0, 90, 60)
                              .line(90, 60, 0, 60)
                              .line(0, 60, 0, 0.2)
                              .text());
  }

  /// What describe_part prints of a part file, without the part's name; what it says where it
  /// refuses.
  std::string describe(const std::string& yaml) {
    const int status = run(dir_.write("part.yaml", yaml));
    EXPECT_TRUE(status == 0 || status == 2) << status;
    return status == 0 ? out_ : "refused: " + error_;
  }

  /// The text with `from` replaced, which must stand in it.
  static std::string with(const std::string& text, const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.substr(0, at) + to + text.substr(at + from.size());
  }
};

const std::string kPart =
    "drawing: plate.dxf\n"
    "thickness_mm: 3\n"
    "print_layers: [INK]\n"
    "tool_radius_mm: 5\n"
    "pick_poses: [{name: suction, face: back, position_mm: [45, 30, -3], rpy_deg: [0, 0, 0]}]\n";

TEST_F(PartKeys, ChangeWhatIsRead) {
  const std::string before = describe(kPart);
  ASSERT_EQ(before.find("refused"), std::string::npos) << before;
  const auto holes = [](const std::string& text) { return YAML::Load(text)["holes"].as<int>(); };
  EXPECT_EQ(holes(before), 2);
  EXPECT_EQ(YAML::Load(before)["prints"].as<int>(), 1);

  const std::string other = describe(with(kPart, "drawing: plate.dxf", "drawing: other.dxf"));
  EXPECT_NE(other.find("size_mm: [80"), std::string::npos) << other;
  const std::string inches = describe(kPart + "units: inch\n");
  EXPECT_NE(inches.find("size_mm: [2286"), std::string::npos) << inches;
  const std::string through = with(kPart, "[45, 30, -3]", "[45, 30, 0]");
  EXPECT_NE(describe(through).find("on the far face"), std::string::npos) << out_;
  EXPECT_EQ(describe(with(through, "thickness_mm: 3", "thickness_mm: 0")).find("far face"),
            std::string::npos)
      << out_;
  EXPECT_EQ(holes(describe(kPart + "skip_layers: [BORE]\n")), 1);
  EXPECT_EQ(holes(describe(kPart + "keep_layers: [CUT, INK]\n")), 1);
  const std::string unprinted =
      describe(with(kPart, "print_layers: [INK]", "print_layers: [NONE]"));
  EXPECT_NE(unprinted, before);
  const std::string wide = describe(with(kPart, "tool_radius_mm: 5", "tool_radius_mm: 25"));
  EXPECT_NE(wide.find("radius is 25.0 mm"), std::string::npos) << wide;
}

TEST_F(PartKeys, OfPickPosesChangeWhatIsRead) {
  const std::string before = describe(kPart);
  const std::string named = describe(with(kPart, "name: suction", "name: magnet"));
  EXPECT_NE(named.find("pick_poses: [magnet]"), std::string::npos) << named;
  const std::string front = describe(with(kPart, "face: back", "face: front"));
  EXPECT_NE(front.find("does not point into the part"), std::string::npos) << front;
  const std::string turned = describe(with(kPart, "rpy_deg: [0, 0, 0]", "rpy_deg: [180, 0, 0]"));
  EXPECT_NE(turned.find("does not point into the part"), std::string::npos) << turned;
  const std::string away = describe(with(kPart, "[45, 30, -3]", "[145, 30, -3]"));
  EXPECT_NE(away.find("outside of the part"), std::string::npos) << away;
}

// What the node answers: a plate looks the same after half a turn, and upside down.
TEST_F(PartKeys, SymmetricCopiesPickPoses) {
  const std::string plate =
      "drawing: other.dxf\n"
      "pick_poses: [{name: suction, face: back, position_mm: [20, 25, 0], symmetric: true}]\n";
  const auto count = [&](const std::string& yaml) {
    return PartModel(loadPartFile(dir_.write("part.yaml", yaml))).pickPoses().size();
  };
  EXPECT_EQ(count(plate), 4u);
  EXPECT_EQ(count(with(plate, "symmetric: true", "symmetric: false")), 1u);
}

TEST_F(PartKeys, JoinToleranceClosesAGap) {
  const std::string open = describe("drawing: gap.dxf\n");
  EXPECT_NE(open.find("refused"), std::string::npos) << open;
  const std::string closed = describe("drawing: gap.dxf\njoin_tolerance_mm: 0.3\n");
  EXPECT_NE(closed.find("size_mm: [90"), std::string::npos) << closed;
}

}  // namespace
}  // namespace planar_bin_picking
