// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// From the evidence for and against a pose to the probability that it is right, by one formula for
/// all parts, pictures and sizes (logistic regression; test/benchmark/README.md says on what).
/// Right is what the benchmark calls so: within 2 mm aside, 8 mm in depth, 2 degrees in turn and
/// 6 in tilt of a part that lies there with this face up.

#include "planar_bin_picking/base/types.h"

namespace planar_bin_picking {

/// @return  0..1; the more, the more speaks for the pose and the less against it
double probabilityRight(const PoseEvidence& evidence);

/// How probable the pose's tilt is right, by its covariance alone (Gaussian): the two tilts that an
/// outline may leave open are part of that.
double probabilityOfTilt(const RefinedPose& pose);

/// The largest standard deviation of the pose within the part's own plane, metres.
double sigmaInPlane(const RefinedPose& pose);

}  // namespace planar_bin_picking
