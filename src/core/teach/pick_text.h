// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The pick poses within a part file's text. Only they change: what a person wrote around them, the
/// comments included, stays as it is, byte for byte.

#include "planar_bin_picking/part/pick_poses.h"
#include "teach/pick_names.h"

#include <string>
#include <vector>

namespace planar_bin_picking {

/// Poses are told apart by their names. In one that has changed, only the values that have changed
/// are written anew; comments on lines of their own between the poses stay where they are, also
/// where a pose goes or another comes there.
/// @param text   a part file that can be read
/// @param poses  all that it is to have, in the order that it is to have
/// @param names  of those that the file calls otherwise
/// @throws std::runtime_error  it is written so that this cannot be done safely: why, and what to
///         change by hand. Lengths are rounded to 0.001 mm, angles to 0.001 degrees.
std::string withPickPoses(const std::string& text, const std::vector<PickPose>& poses,
                          const FormerNames& names = {});

/// Whether they differ by more than that rounding.
bool isSamePick(const PickPose& a, const PickPose& b);

}  // namespace planar_bin_picking
