// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/dxf/dxf_names.h"

#include "support/drawing_fixture.h"

#include <chrono>

namespace planar_bin_picking {
namespace {

using Names = DrawingTest;

TEST(DxfNames, AreDecodedByTheirCodePage) {
  EXPECT_EQ(DxfNames("ANSI_1252", "AC1015")
                .decode("Ma\xdf"
                        "e"),
            "Maße");
  EXPECT_EQ(DxfNames("ANSI_1250", "AC1015").decode("\x8e\xe1k"), "Žák");
  EXPECT_EQ(DxfNames("ansi_1251", "AC1018").decode("\xee\xf1\xfc"), "ось");
  EXPECT_EQ(DxfNames("DOS850", "AC1009")
                .decode("\x81"
                        "ber"),
            "über");
  EXPECT_EQ(DxfNames("ANSI_932", "AC1015").decode("\x92\x86\x90\x53"), "中心");
  EXPECT_EQ(DxfNames("ISO8859-1", "AC1015").decode("\xe9"), "é");
  EXPECT_EQ(DxfNames("", "").decode("\xe9"), "é");  // nothing stated
}

TEST(DxfNames, AreUtf8SinceTheYear2007AndWhereTheyAreValid) {
  EXPECT_EQ(DxfNames("ANSI_1252", "AC1021").decode("Maße"), "Maße");
  EXPECT_EQ(DxfNames("ANSI_1251", "AC1027").decode("Maße"), "Maße");
  EXPECT_EQ(DxfNames("ANSI_1252", "AC1015").decode("Maße"), "Maße");  // states one, writes another
  EXPECT_EQ(DxfNames("no such page", "AC1015").decode("\xe9"), "é");
}

TEST(DxfNames, HaveEscapesResolved) {
  const DxfNames names;
  EXPECT_EQ(names.decode("Ma\\U+00DFe"), "Maße");
  EXPECT_EQ(names.decode("\\U+4E2D\\u+5fc3"), "中心");
  EXPECT_EQ(names.decode("\\U+D83D\\U+DE00"), "\xf0\x9f\x98\x80");
  EXPECT_EQ(names.decode("\\M+19286x"), "中x");  // byte pair of the Japanese page
  EXPECT_EQ(names.decode("\\M+5D6D0"), "中");    // and of the Chinese one
  for (const char* plain : {"a\\b", "\\U+00D", "\\U+ZZZZ", "\\M+9F92", "\\M+Z9286", "\\"})
    EXPECT_EQ(names.decode(plain), plain);
}

TEST(DxfNames, DoNotTellCaseApart) {
  EXPECT_EQ(upperCase("kontur_äöü éñ"), "KONTUR_ÄÖÜ ÉÑ");
  EXPECT_EQ(upperCase("žluťoučký ÿ"), "ŽLUŤOUČKÝ Ÿ");
  EXPECT_EQ(upperCase("őű łódź"), "ŐŰ ŁÓDŹ");
  EXPECT_EQ(upperCase("осевая ё љ"), "ОСЕВАЯ Ё Љ");
  EXPECT_EQ(upperCase("άξονας"), "ΆΞΟΝΑΣ");
  EXPECT_EQ(upperCase("ế ÷ ß 中"), "Ế ÷ ß 中");
  EXPECT_EQ(upperCase("\xe4 \xff"), "\xe4 \xff");  // no UTF-8: left as it is
}

TEST(DxfNames, MatchPatterns) {
  EXPECT_TRUE(matchesPattern("Dimensions", "DIM*"));
  EXPECT_TRUE(matchesPattern("GRAVÍR", "gravír"));
  EXPECT_TRUE(matchesPattern("abcabd", "*ab*d"));
  EXPECT_TRUE(matchesPattern("a", "*a*"));
  EXPECT_TRUE(matchesPattern("", "*"));
  EXPECT_FALSE(matchesPattern("", "a"));
  EXPECT_FALSE(matchesPattern("DI", "DIM*"));
  EXPECT_FALSE(matchesPattern("XDIM", "DIM*"));
  EXPECT_FALSE(matchesPattern("DIMX", "DIM"));
  EXPECT_FALSE(matchesPattern("abcabc", "*ab*d"));
  EXPECT_TRUE(matchesPattern("A[1]?\\B", "a[1]?\\*"));  // nothing but the star is special
  EXPECT_FALSE(matchesPattern("A1", "A[1]"));
  EXPECT_FALSE(matchesPattern("AB", "A?"));
  EXPECT_FALSE(matchesPattern("B", "\\B"));
  EXPECT_TRUE(matchesPattern(".dim/x", "*x"));
}

TEST(DxfNames, AreFoundBehindTheDrawingTheyComeFrom) {
  EXPECT_TRUE(matchesAny("A3-frame|Dim", {"CUT", "DIM*"}));
  EXPECT_TRUE(matchesAny("A3$0$DIM", {"DIM*"}));
  EXPECT_TRUE(matchesAny("A3$12$DIM", {"A3*"}));
  EXPECT_FALSE(matchesAny("A3$DIM", {"DIM*"}));
  EXPECT_FALSE(matchesAny("A3$$DIM", {"DIM*"}));
  EXPECT_FALSE(matchesAny("$DIM", {"DIM*"}));
  EXPECT_FALSE(matchesAny("CUT", {}));
}

TEST(DxfNames, MatchLongPatternsAtOnce) {
  std::string pattern;
  for (int i = 0; i < 100; ++i) pattern += "*a";
  const auto start = std::chrono::steady_clock::now();
  EXPECT_FALSE(matchesPattern(std::string(10000, 'a'), pattern + "*b"));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(1));
}

TEST_F(Names, OfLayersInPartFilesAreMeant) {
  const auto drawing = [](const std::string& layer) {
    DxfWriter dxf;
    dxf.variable("$ACADVER", {{1, "AC1015"}}).variable("$DWGCODEPAGE", {{3, "ANSI_1252"}});
    return dxf.rectangle(0, 0, 40, 20).line(0, 0, 60, 90, layer);
  };
  DrawingParams params;
  params.skip_layers = {"maße"};
  EXPECT_EQ(load(drawing("Ma\\U+00DFe"), params).left_out.at(0), "layer Maße: 1 entity");
  EXPECT_EQ(load(drawing("MA\xdf"
                         "E"),
                 params)
                .left_out.at(0),
            "layer MAßE: 1 entity");
  EXPECT_TRUE(refused(drawing("Ma\\U+00DFe"), {"open contour", "\"Maße\""}));
}

}  // namespace
}  // namespace planar_bin_picking
