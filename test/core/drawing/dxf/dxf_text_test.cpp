// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "support/drawing_fixture.h"

#include <gtest/gtest.h>

#include <locale>

namespace planar_bin_picking {
namespace {

using DxfFileText = DrawingTest;

TEST_F(DxfFileText, RefusesWhatIsNoDxf) {
  EXPECT_TRUE(refuses([&] { loadDrawing(dir_.path("none.dxf")); }, {"none.dxf", "cannot be read"}));
  EXPECT_TRUE(refused("", {"empty"}));
  EXPECT_TRUE(refused("Dear colleague,\nhere is the drawing.\n", {"line 1", "not a DXF file"}));
  EXPECT_TRUE(
      refused(std::string("AutoCAD Binary DXF\r\n\x1a\0\0\0", 25), {"binary DXF", "ASCII"}));
  EXPECT_TRUE(refused("AC1027 and so on", {"DWG", "ASCII DXF"}));
  EXPECT_TRUE(refused(std::string("\x7f"
                                  "ELF\0\0\1",
                                  7),
                      {"not a text file"}));
}

TEST_F(DxfFileText, RefusesTruncatedFilesWhereverTheyEnd) {
  const std::string whole = DxfWriter().rectangle(0, 0, 30, 20).circle(9, 9, 3).text();
  // Without the last line break the EOF marker is still there.
  for (std::size_t size = 1; size + 2 < whole.size(); ++size) {
    EXPECT_TRUE(
        refuses([&] { loadDrawing(dir_.write("part.dxf", whole.substr(0, size))); }, {"part.dxf"}))
        << size;
  }
  EXPECT_TRUE(refused(whole.substr(0, whole.size() / 2), {"truncated"}));
}

TEST_F(DxfFileText, RefusesDamagedNumbersAndCounts) {
  EXPECT_TRUE(refused(DxfWriter().entity("CIRCLE", "CUT", {{10, "x1"}, {20, 0}, {40, 5}}),
                      {"line", "x1", "CIRCLE"}));
  EXPECT_TRUE(refused(DxfWriter().entity("CIRCLE", "CUT", {{10, 0}, {20, 0}, {40, -5}}),
                      {"CIRCLE", "CUT", "radius"}));
  EXPECT_TRUE(refused(DxfWriter().entity("LWPOLYLINE", "CUT", {{90, 3}, {70, 1}, {10, 0}, {20, 0}}),
                      {"LWPOLYLINE", "states 3", "has 1"}));
}

TEST_F(DxfFileText, ReadsWindowsLinesCommentsAndByteOrderMarks) {
  std::string text = "999\nmade by hand\n" + DxfWriter().rectangle(0, 0, 30, 20).text();
  for (std::size_t i = 0; (i = text.find('\n', i)) != std::string::npos; i += 2)
    text.replace(i, 1, "\r\n");
  EXPECT_EQ(loadDrawing(dir_.write("part.dxf", "\xef\xbb\xbf" + text)).loops.size(), 1u);
}

std::string withLineEnds(std::string text, const std::string& end) {
  for (std::size_t i = 0; (i = text.find('\n', i)) != std::string::npos; i += end.size())
    text.replace(i, 1, end);
  return text;
}

TEST_F(DxfFileText, ReadsTheLineEndsOfAllSystems) {
  const std::string text = DxfWriter().rectangle(0, 0, 30, 20).circle(9, 9, 3).text();
  for (const char* end : {"\r", "\r\n", "\r\r\n", "\n", " \t\n"})
    EXPECT_EQ(load(withLineEnds(text, end)).loops.size(), 2u);
  const std::size_t half = text.find("ENTITIES") + 9;
  const std::string first = text.substr(0, half), last = text.substr(half);
  for (const char* a : {"\r", "\r\n", "\n"}) {
    for (const char* b : {"\r", "\r\n", "\n"})
      EXPECT_EQ(load(withLineEnds(first, a) + withLineEnds(last, b)).loops.size(), 2u);
  }
}

TEST_F(DxfFileText, ReadsEmptyValues) {
  for (const char* end : {"\r", "\r\n", "\n"}) {
    DxfWriter dxf;
    dxf.entity("TEXT", "CUT", {{1, ""}, {10, 5}}).rectangle(0, 0, 30, 20);
    EXPECT_EQ(load(withLineEnds(dxf.text(), end)).loops.size(), 1u);
  }
}

TEST_F(DxfFileText, ReadsNothingBehindItsEnd) {
  EXPECT_EQ(load(DxfWriter().rectangle(0, 0, 30, 20).text() + "\x1a\nand more").loops.size(), 1u);
}

TEST_F(DxfFileText, NamesTheLine) {
  EXPECT_TRUE(
      refused("0\nSECTION\n2\nENTITIES\nzero\nLINE\n", {"line 5", "\"zero\"", "group code"}));
  EXPECT_TRUE(refused("0\nSECTION\n\n2\nENTITIES\n", {"line 3", "group code"}));
  EXPECT_TRUE(
      refused("0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\nmm\n0\nEOF\n", {"line 8", "\"mm\""}));
}

TEST_F(DxfFileText, ReadsDecimalCommas) {
  std::string text = DxfWriter().rectangle(0, 0, 30.5, 20.25).text();
  for (const char* number : {"30.5", "20.25"}) {
    for (std::size_t i = 0; (i = text.find(number, i)) != std::string::npos; ++i)
      text[text.find('.', i)] = ',';
  }
  EXPECT_TRUE(boxNear(load(text).loops.at(0), 0, 0, 30.5, 20.25));
  const auto circle = [&](const char* radius) {
    DxfWriter dxf = DxfWriter().rectangle(-50, -50, 50, 50);
    return dxf.entity("CIRCLE", "CUT", {{10, 0}, {20, 0}, {40, radius}}).text();
  };
  EXPECT_TRUE(refused(circle("1,2,3"), {"line", "\"1,2,3\"", "not a number"}));
  EXPECT_TRUE(refused(circle("1,234.5"), {"\"1,234.5\""}));
}

TEST_F(DxfFileText, RefusesNumbersThatAreNone) {
  for (const char* radius : {"nan", "inf", "-inf", "1e999", "0x10", "", "1 2", "5mm", "1e-320"}) {
    EXPECT_TRUE(refused(DxfWriter()
                            .rectangle(0, 0, 30, 20)
                            .entity("CIRCLE", "CUT", {{10, 9}, {20, 9}, {40, radius}}),
                        {"line", "CIRCLE", std::string("\"") + radius + "\""}))
        << radius;
  }
  EXPECT_TRUE(refused(DxfWriter().polyline({{0, 0, 1e-320}, {30, 0}, {30, 20}, {0, 20}}),
                      {"e-321", "too small"}));
  for (const char* radius : {"5", "+5", " 5.0 ", "5e0", "5.", "0.5E+1"}) {
    EXPECT_EQ(load(DxfWriter()
                       .rectangle(0, 0, 30, 20)
                       .entity("CIRCLE", "CUT", {{10, 9}, {20, 9}, {40, radius}}))
                  .loops.size(),
              2u)
        << radius;
  }
}

struct DecimalComma : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
};

TEST_F(DxfFileText, ReadsPointsWhereTheLocaleHasCommas) {
  const std::string path = dir_.write("part.dxf", DxfWriter().rectangle(0, 0, 30.5, 20.25).text());
  const std::locale before =
      std::locale::global(std::locale(std::locale::classic(), new DecimalComma));
  const Drawing drawing = loadDrawing(path);
  const char point = std::use_facet<std::numpunct<char>>(std::locale()).decimal_point();
  std::locale::global(before);
  EXPECT_TRUE(boxNear(drawing.loops.at(0), 0, 0, 30.5, 20.25));
  EXPECT_EQ(point, ',');  // and the process keeps its locale
}

TEST_F(DxfFileText, ReadsTheSameTwice) {
  const std::string path = std::string(PACKAGE_DIR) + "/config/parts/bracket.dxf";
  const Drawing a = loadDrawing(path), b = loadDrawing(path);
  ASSERT_EQ(a.loops.size(), b.loops.size());
  for (std::size_t i = 0; i < a.loops.size(); ++i) EXPECT_EQ(a.loops[i].points, b.loops[i].points);
}

TEST_F(DxfFileText, ReadsTheBracket) {
  // With dimensions, centre lines and a title frame, as a CAD program writes them.
  const Drawing drawing = loadDrawing(std::string(PACKAGE_DIR) + "/config/parts/bracket.dxf");
  ASSERT_EQ(drawing.loops.size(), 4u);
  EXPECT_TRUE(boxNear(drawing.loops[0], 0, 0, 120, 80));
  EXPECT_EQ(count(drawing, LoopKind::kHole), 3);
}

}  // namespace
}  // namespace planar_bin_picking
