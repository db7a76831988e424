// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace planar_bin_picking {

/// Writes a file whole or not at all, also if the power goes: beside its place, flushed to the
/// disk, then moved there. The file that was there is kept as `<path>.before`.
/// @throws std::runtime_error  the path and the system's reason
void writeAtomically(const std::string& path, const std::string& content);

}  // namespace planar_bin_picking
