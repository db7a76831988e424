// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/dxf/drawing_units.h"

#include "drawing/dxf/dxf_names.h"

#include <map>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

/// How people write the units that a part file may name.
DrawingUnit unitCalled(const std::string& told) {
  static const std::map<std::string, DrawingUnit> kUnits = [] {
    std::map<std::string, DrawingUnit> units;
    const auto add = [&](const DrawingUnit& unit, std::initializer_list<const char*> spellings) {
      for (const char* spelling : spellings) units[spelling] = unit;
    };
    add({"mm", 1.0}, {"MM", "MILLIMETRE", "MILLIMETRES", "MILLIMETER", "MILLIMETERS"});
    add({"cm", 10.0}, {"CM", "CENTIMETRE", "CENTIMETRES", "CENTIMETER", "CENTIMETERS"});
    add({"m", 1000.0}, {"M", "METRE", "METRES", "METER", "METERS"});
    add({"inch", 25.4}, {"INCH", "INCHES", "IN"});
    add({"ft", 304.8}, {"FT", "FOOT", "FEET"});
    return units;
  }();
  const auto it = kUnits.find(upperCase(told));
  if (it != kUnits.end()) return it->second;
  throw std::invalid_argument("units is \"" + told + "\"; known are mm, cm, m, inch, ft");
}

/// By the code of $INSUNITS; 0 is "none".
DrawingUnit unitOfCode(int code) {
  static const std::map<int, DrawingUnit> kUnits = {{0, {"mm", 1.0}},
                                                    {1, {"inch", 25.4}},
                                                    {2, {"ft", 304.8}},
                                                    {3, {"mile", 1609344.0}},
                                                    {4, {"mm", 1.0}},
                                                    {5, {"cm", 10.0}},
                                                    {6, {"m", 1000.0}},
                                                    {7, {"km", 1e6}},
                                                    {8, {"microinch", 25.4e-6}},
                                                    {9, {"mil", 25.4e-3}},
                                                    {10, {"yard", 914.4}},
                                                    {11, {"angstrom", 1e-7}},
                                                    {12, {"nm", 1e-6}},
                                                    {13, {"micron", 1e-3}},
                                                    {14, {"dm", 100.0}},
                                                    {15, {"dam", 1e4}},
                                                    {16, {"hm", 1e5}},
                                                    {21, {"US survey ft", 1200e3 / 3937}},
                                                    {22, {"US survey inch", 100e3 / 3937}},
                                                    {23, {"US survey yard", 3600e3 / 3937}}};
  const auto it = kUnits.find(code);
  if (it != kUnits.end()) return it->second;
  throw std::runtime_error(
      "$INSUNITS is " + std::to_string(code) +
      ", a unit that no part is drawn in; set the drawing's unit to millimetres ($INSUNITS 4), or "
      "state it in the part file as units");
}

}  // namespace

DrawingUnit unitOf(const DxfHeader& header, const std::string& told,
                   std::vector<std::string>* warnings) {
  if (!told.empty()) return unitCalled(told);
  const int code = header.insunits.value_or(0);
  if (code == 0 && header.measurement == 0) {
    warnings->push_back(
        "the file states no unit ($INSUNITS), but English measurement ($MEASUREMENT 0): read as "
        "mm; if it is drawn in inches, write units: inch into the part file");
  }
  return unitOfCode(code);
}

}  // namespace planar_bin_picking
