// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Reads whole files that a user or a folder names. What is no regular file (a folder, a pipe, a
/// device) would block or never end: it is refused before a byte is read.

#include <cstddef>
#include <string>

namespace planar_bin_picking {

/// @param bytes_max  more than this is refused before it is read
/// @throws std::runtime_error  naming the path: not there, not readable, no regular file, too large
std::string readRegularFile(const std::string& path, std::size_t bytes_max);

}  // namespace planar_bin_picking
