// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Last step: what of the ranked list answers the request.

#include "planar_bin_picking/image/camera.h"
#include "planar_bin_picking/locate/locate_request.h"

#include <vector>

namespace planar_bin_picking {

/// The same place, expressed as the other face: a mirror-symmetric part turned about its mirror
/// axis. Nobody can tell the two apart where nothing is printed on it.
/// @pre the part's outline is mirror-symmetric
Detection turnedOver(const Detection& detection, const PartModel& part);

/// Splits the list by the request's face, then by its distances, and cuts what is left to
/// max_parts; all in the list's order. What is tilted beyond the limit is in neither list.
/// @param ranked  without poses that overlap better ones. If the face were judged before that, a
///                worse pose with the face asked for would replace the right pose of a part whose
///                other face is up
/// @param out     its detections and its withheld ones are set
void answerRequest(const std::vector<Detection>& ranked, const LocateRequest& request,
                   const Camera& camera, double tilt_limit_deg, LocateResult* out);

}  // namespace planar_bin_picking
