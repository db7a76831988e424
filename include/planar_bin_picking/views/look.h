// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A part that was located in one view is looked at in one more: what one picture cannot tell, a
/// second one does.
///
/// The part is sought about its predicted place in the new picture, nearer and farther along the
/// first camera's ray and tilted either way, so that a first pose in the wrong depth or with the
/// wrong one of two tilts is found, too. The answer is the pose that fits all views together
/// (src/core/views/joint_pose.h). A part that fits either view, but no pose of which fits both, has
/// moved between the pictures: the two are never averaged.

#include "planar_bin_picking/locate/params.h"
#include "planar_bin_picking/part/part_model.h"
#include "planar_bin_picking/views/view.h"

#include <string>
#include <vector>

namespace planar_bin_picking {

enum class LookStatus {
  kConfirmed,     ///< all views agree with the pose that was known, which is better known now
  kCorrected,     ///< all views agree on another pose than the one that was known
  kMoved,         ///< the part is seen in either view, at places that no pose joins
  kContradicted,  ///< the new picture shows the place, and the part is not there
  kNotSeen,       ///< the place is outside of the new picture, or hidden in it
};

struct LookResult {
  LookStatus status = LookStatus::kNotSeen;
  /// In the first view's frame. CONFIRMED, CORRECTED: of all views together. MOVED: where the new
  /// view alone has it. Else as it was.
  Detection detection;
  double moved = 0.0;      ///< metres by which the pose's centre is another one, unless not seen
  double moved_rad = 0.0;  ///< turn between the two
  double seen = 0.0;       ///< inlier score in the new view, 0..1
  std::string text;        ///< what was seen, in numbers, and what to do
};

const char* nameOf(LookStatus status);  ///< in lower case, as files have it

/// A located part and the pictures that its pose rests on, the first one first.
struct TrackedPart {
  Detection detection;  ///< in the first view's frame
  std::vector<ViewPtr> views;
};

class Looker {
 public:
  /// @throws std::invalid_argument  a parameter out of its range, named by its key
  explicit Looker(const LocatorParams& params = {});

  /// @param known  in the first view's frame, by that view or by all but the last
  /// @param views  at least two: where it was located, looks that confirmed it, the new one
  /// @throws std::invalid_argument  fewer than two views
  /// Cost: some 20 ms on two cores.
  LookResult look(const Detection& known, const PartModel& part,
                  const std::vector<ViewPtr>& views) const;
  /// The same with what is known of the part by now; where the new view agrees, it is one of the
  /// part's views from then on.
  LookResult look(const PartModel& part, const ViewPtr& view, TrackedPart* tracked) const;

 private:
  struct Seen;
  void judge(const Detection& known, const std::vector<ViewPtr>& views, const Seen& seen,
             LookResult* out) const;

  LocatorParams params_;
};

}  // namespace planar_bin_picking
