// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "step_file.h"

#include <stdexcept>

namespace planar_bin_picking {

StepPart readStep(const std::string& path) {
  throw std::runtime_error(path +
                           ": STEP is not read by this build, which is without Open CASCADE; "
                           "install libocct-data-exchange-dev and build again, or export DXF");
}

}  // namespace planar_bin_picking
