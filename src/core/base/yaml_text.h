// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Words and numbers as they stand in YAML that others read. The library's emitter writes numbers
/// as the process's locale has them (decimal commas, dots between thousands) and a part called 12
/// or true without quotes, so that a reader takes it for a number.

#include <string>
#include <vector>

namespace planar_bin_picking {

/// A word in quotes where it needs them; on one line, whatever is in it.
std::string yamlText(const std::string& text);

/// A finite number with a decimal point in every locale.
/// @param decimals  after the point
std::string yamlNumber(double value, int decimals);

/// Ten digits, in every locale; .nan where it is no number.
std::string yamlNumber(double value);

/// `[a, b]` of texts.
std::string yamlList(const std::vector<std::string>& texts);

/// `[1.0, 2.5]`.
std::string yamlList(const std::vector<double>& values, int decimals);

}  // namespace planar_bin_picking
