// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/dxf/line_types.h"

#include "drawing/dxf/dxf_names.h"

namespace planar_bin_picking {
namespace {

const std::vector<std::string> kEdges = {"CONTINU*",    "KONTINU*",      "SOLID*",   "*-SOLID",
                                         "AUSGEZOGEN*", "DURCHGEZOGEN*", "VOLL*",    "PLEIN*",
                                         "ACAD_ISO01*", "ISO01*",        "ISO-01*",  "JIS_01*",
                                         "THICK*",      "THIN*",         "VISIBLE*", "OUTLINE*"};

const std::vector<std::string> kNeighbours = {
    "*PHANTOM*",    "*FANTOM*",    "*FANTASMA*",  "*DIVIDE*", "*ZWEIPUNKT*",
    "*DEUX POINT*", "ACAD_ISO05*", "ACAD_ISO09*", "JIS_09*",  "GEDEELD*"};

/// AutoCAD's and its translations, SolidWorks', ISO's and JIS's.
const std::vector<std::string> kAnnotation = {
    // English
    "*CENTER*", "*CENTRE*", "*HIDDEN*", "*DASH*", "*DOT*", "BORDER*", "AXIS*", "AXES*", "*CHAIN*",
    "ACAD_ISO*", "ISO0*", "ISO1*", "ISO-*", "ISO DASH*", "JIS_*", "GAS_LINE*", "FENCE*",
    "HOT_WATER*", "TRACKS*", "ZIGZAG*", "BATTING*", "CONSTRUCTION*", "STITCH*",
    // German
    "*MITTE*", "*STRICH*", "*PUNKT*", "*VERDECKT*", "RAND*", "ACHS*", "*GETRENNT*", "HILFS*",
    "*UNSICHTBAR*",
    // French
    "AXE*", "*TRAIT*", "*MIXTE*", "*TIRET*", "*POINTILL*", "*CACHE*", "*CACH\u00c9*",
    "*INTERROMPU*", "BORDURE*",
    // Spanish, Portuguese
    "*CENTRO*", "*OCULT*", "*TRAZO*", "*TRAZ*PUNTO*", "*PUNTO*", "EJE*", "*TRACEJ*", "*TRA\u00c7O*",
    "*TRACO*", "*PONTO*", "*EIXO*", "*ESCONDID*", "BORDE*",
    // Italian
    "*TRATT*", "*NASCOST*", "*PUNT*", "ASSE*", "ASSI*",
    // Dutch
    "*HARTLIJN*", "*STREEP*", "*STIPPEL*", "*VERBORGEN*", "*ONDERBROKEN*",
    // Polish, Czech, Slovak, Hungarian
    "*KRESK*", "*PUNKTOW*", "*OSIOW*", "*UKRYT*", "*PRZERYW*", "*P\u0158ERU\u0160*",
    "*PRERU\u0160*", "*\u010c\u00c1RKOV*", "*CARKOV*", "*\u010cERCH*", "*CERCH*", "*STRED*",
    "*ST\u0158ED*", "*SKRYT*", "*TE\u010cKOV*", "*TECKOV*", "*BODKOV*", "*OS", "*OSA*", "*SZAGGAT*",
    "*TAKART*", "*K\u00d6Z\u00c9P*",
    // Swedish, Danish, Norwegian, Finnish
    "*STREK*", "*PRICK*", "*SKJULT*", "*DOLD*", "*PRIK*", "*KATKO*", "*KESKI*",
    // Russian, Japanese, Chinese
    "*\u041e\u0421\u0415\u0412*", "*\u0428\u0422\u0420\u0418\u0425*",
    "*\u041f\u0423\u041d\u041a\u0422\u0418\u0420*", "*\u041d\u0415\u0412\u0418\u0414\u0418\u041c*",
    "*\u4e2d\u5fc3*", "*\u865a\u7ebf*", "*\u70b9\u753b*", "*\u9396\u7dda*", "*\u7834\u7dda*",
    "*\u4e00\u70b9*"};

}  // namespace

LineMeaning meaningOf(const std::string& linetype, const DxfFile& file) {
  const std::string name = upperCase(linetype);
  if (name.empty() || name == "CONTINUOUS" || name == "BYLAYER" || name == "BYBLOCK")
    return LineMeaning::kEdge;
  const auto defined = file.dashed_linetypes.find(name);
  const bool known = defined != file.dashed_linetypes.end();
  const bool neighbour = matchesAny(name, kNeighbours);
  if (known && defined->second)
    return neighbour ? LineMeaning::kNeighbour : LineMeaning::kAnnotation;
  if (matchesAny(name, kEdges)) return LineMeaning::kEdge;
  if (neighbour) return LineMeaning::kNeighbour;
  if (matchesAny(name, kAnnotation)) return LineMeaning::kAnnotation;
  return known ? LineMeaning::kEdge : LineMeaning::kUnknown;
}

}  // namespace planar_bin_picking
