// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Changes values in a YAML file that people write, too: comments, order and everything else stay
/// as they are.

#include <map>
#include <string>
#include <vector>

namespace planar_bin_picking_ros {

/// Keys, from the outermost.
using YamlPath = std::vector<std::string>;

/// A number as every YAML reader takes it: with a decimal point, without an exponent.
std::string yamlNumber(double value);

/// The text with those values: in the place of what stands there, or at the end of their map.
/// @param values  {path: value as YAML, on one line}
/// @throws std::invalid_argument  the text is no YAML map, or is written in a way that this cannot
///         change, such as {a: 1}: which key; the result is always read again and compared
std::string withYamlValues(const std::string& text, const std::map<YamlPath, std::string>& values);

/// The file likewise, in one step; as it was stays beside it, with .before behind its name.
/// @throws std::runtime_error  unreadable, cannot be written, or as withYamlValues: path and reason
void saveYamlValues(const std::string& path, const std::map<YamlPath, std::string>& values);

}  // namespace planar_bin_picking_ros
