// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The drawings of a calibration's report, as SVG.

#include "calibrate/report_page.h"
#include "planar_bin_picking/calibrate/hand_eye/hand_eye.h"

namespace planar_bin_picking {

/// Residuals of all corners about zero; the ring is three standard deviations.
void residualPlot(const HandEyeResult& result, Page* page);

/// The corners over the image, each with its residual as a line, enlarged.
void residualVectorPlot(const HandEyeProblem& problem, const HandEyeResult& result, Page* page);

/// Expected error of a part's position at the working distance, over the image.
void uncertaintyMap(const HandEyeProblem& problem, const HandEyeResult& result, Page* page);

/// The cameras about the board, which is drawn as large as it is.
/// @param across  board axis that leads down in the drawing: 1, as the cameras see the board; 2,
/// from the side
void posesPlot(const Board& board, const HandEyeResult& result, int across, const char* caption,
               Page* page);

}  // namespace planar_bin_picking
