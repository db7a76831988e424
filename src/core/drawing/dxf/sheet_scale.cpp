// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drawing/dxf/sheet_scale.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <locale>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace planar_bin_picking {
namespace {

/// Dimensions are rounded to a digit or two behind the point.
constexpr double kSame = 0.01;
constexpr double kWhole = 1e-6;  // of a power of ten's exponent: rounding

bool isSame(double a, double b) { return std::abs(a - b) <= kSame * std::max(a, b); }

std::string number(double value) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << std::setprecision(6) << value;
  return text.str();
}

/// A display in another unit: millimetres or inches of what is drawn in its own.
bool isUnit(double factor, double mm_per_unit) {
  return isSame(factor, 1.0) || isSame(factor, mm_per_unit) || isSame(factor, mm_per_unit / 25.4);
}

/// Metres that are shown as centimetres, and the like: a factor alone says no more.
bool isPowerOfTen(double factor) {
  const double power = std::log10(factor);
  return std::abs(power - std::round(power)) < kWhole;
}

/// Where the factor is that of another unit to the millimetre, that is the likelier reason.
std::string unitHint(double factor) {
  for (const auto& [unit, mm] :
       {std::pair("inch", 25.4), std::pair("cm", 10.0), std::pair("m", 1000.0)})
    if (isSame(factor, mm))
      return std::string(". If it is drawn in another unit, write units: ") + unit +
             " into the part file";
  return "";
}

/// $DIMLFAC of this dimension: its own, its style's, or the header's. Negative ones are for the
/// sheet in paper space only.
double factorOf(const DxfDimension& dimension, const DxfFile& file) {
  const auto style = file.dimension_factors.find(dimension.style);
  const double factor = dimension.factor                        ? *dimension.factor
                        : style != file.dimension_factors.end() ? style->second
                                                                : file.header.dimension_factor;
  return factor > 0.0 ? factor : 1.0;
}

/// What one dimension says of the scale.
struct Statement {
  const DxfDimension* dimension = nullptr;
  double shown = 0.0;      ///< the number on the sheet
  double scale = 1.0;      ///< shown over drawn
  bool supported = false;  ///< the file's own factor says the same
};

Statement statementOf(const DxfDimension& dimension, const DxfFile& file) {
  Statement statement;
  statement.dimension = &dimension;
  const double factor = factorOf(dimension, file);
  if (dimension.written) {
    statement.shown = *dimension.written;
  } else if (dimension.measured && !isSame(*dimension.measured, dimension.drawn)) {
    statement.shown = *dimension.measured;
  } else {
    statement.shown = isPowerOfTen(factor) ? dimension.drawn : factor * dimension.drawn;
  }
  statement.scale = statement.shown / dimension.drawn;
  statement.supported = isSame(statement.scale, factor);
  return statement;
}

}  // namespace

double sheetScale(const DxfFile& file, double mm_per_unit, std::vector<std::string>* warnings) {
  std::vector<Statement> scaled;
  for (const DxfDimension& dimension : file.dimensions) {
    const Statement statement = statementOf(dimension, file);
    if (!isUnit(statement.scale, mm_per_unit)) scaled.push_back(statement);
  }
  if (scaled.empty()) return 1.0;
  const Statement& first = scaled.front();
  const std::string what = "a dimension says " + number(first.shown) + " where " +
                           number(first.dimension->drawn) + " are drawn";
  if (scaled.size() < file.dimensions.size()) {
    warnings->push_back(what + " (" + std::to_string(scaled.size()) + " of " +
                        std::to_string(file.dimensions.size()) +
                        " dimensions): read as drawn; check that the part is drawn 1:1");
    return 1.0;
  }
  const bool agree = std::all_of(scaled.begin(), scaled.end(), [&](const Statement& s) {
    return s.supported && isSame(s.scale, first.scale);
  });
  if (!agree) {
    throw std::runtime_error(
        what +
        ": the sheet seems not to be drawn 1:1; scale the part to its size, or "
        "delete the dimensions if they are wrong" +
        unitHint(first.scale));
  }
  warnings->push_back(what + ", and $DIMLFAC is " + number(first.scale) +
                      ": read as a sheet on which the part is to be taken times " +
                      number(first.scale) + "; check the size");
  return first.scale;
}

}  // namespace planar_bin_picking
