// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The names of pick poses within a part file's text; nothing else of it changes.

#include <map>
#include <string>

namespace planar_bin_picking {

/// What poses are called now -> what the file calls them. Those that keep their names are left out.
using FormerNames = std::map<std::string, std::string>;

/// @param text  a part file that can be read
/// @throws std::runtime_error  a name is written so that this cannot be done safely, and what to
///         change by hand
std::string withNames(const std::string& text, const FormerNames& names);

}  // namespace planar_bin_picking
