// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A part's pick poses with the copies that its symmetry makes of them: where a part looks the same
/// after a turn, the tool can go there, too.

#include "planar_bin_picking/drawing/symmetry.h"
#include "planar_bin_picking/part/part_file.h"

#include <vector>

namespace planar_bin_picking {

/// Turns about the centre, and of a part that equals its mirror image also turns upside down: these
/// copies are for the other face. Copies are named after their pose: "web", "web@2", "web@3" …
/// @param thickness  metres; upside down, a part lies on its other face
/// @return  in order of preference: each pose as given, then its copies, those for its own face
///          first; at most 12 turns of each, evenly spread. A pose with symmetric = false has no
///          copies, and none is made where a pose stands already.
std::vector<PickPose> withSymmetricCopies(const std::vector<PickPose>& poses,
                                          const Symmetry& symmetry, double thickness);

}  // namespace planar_bin_picking
