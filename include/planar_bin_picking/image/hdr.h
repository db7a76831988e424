// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Exposure bracket -> one 8-bit image, before stage 1, for light that one exposure cannot hold.
///
/// The merge is Debevec's and Malik's [5] with a known response in place of an estimated one
/// (machine vision cameras are linear, or their gamma is known), and with the weights that photon
/// noise asks for: light = sum of grey levels / sum of exposure times, over the exposures in which
/// the pixel is not saturated. test/benchmark/hdr.md compares. References are in types.h.

#include <opencv2/core/mat.hpp>

#include <optional>
#include <vector>

namespace planar_bin_picking {

/// One image of the bracket, and for how long the sensor saw light for it.
struct Exposure {
  cv::Mat image;         ///< 8 or 16 bit, one channel
  double seconds = 0.0;  ///< > 0
};

struct HdrParams {
  double response_gamma = 1.0;     ///< grey = light^(1 / gamma): 1 = linear, 2.2 = as for screens
  double black_level = 0.0;        ///< grey without light, as a share of full scale
  double saturation_from = 0.9;    ///< share of full scale from which a grey level counts less ..
  double saturation_to = 0.98;     ///< .. and from which it says nothing any more
  double white_percentile = 99.9;  ///< this share of the pixels, in percent, is not clipped
  double compression = 10.0;       ///< c in log(1 + c light) / log(1 + c); 0 = linear

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("response_gamma", self.response_gamma, 0.2, 5.0);
    visit("black_level", self.black_level, 0.0, 0.5);
    visit("saturation_from", self.saturation_from, 0.1, 1.0);
    visit("saturation_to", self.saturation_to, 0.1, 1.0);
    visit("white_percentile", self.white_percentile, 50.0, 100.0);
    visit("compression", self.compression, 0.0, 1e4);
  }
};

/// @throws std::invalid_argument  a field out of its range, or saturation_from not below
///         saturation_to: key, value, allowed
void validate(const HdrParams& params);

/// The bracket as one image: CV_8U, of the same size. The same for any order of the exposures and
/// any number of threads.
/// @param bracket  N >= 1 exposures of a scene that does not move
/// @param threads  >= 1
/// @throws std::invalid_argument  none; one empty, of another type or size than the first, or
///         with a time that is not positive; params as validate()
/// Cost: O(N pixels); 4 x 5 Mpx in 50 to 110 ms on two cores (`./run bench hdr`)
cv::Mat mergeExposures(const std::vector<Exposure>& bracket, const HdrParams& params, int threads);

/// How many times as much light the image got as the reference did, from their histograms: grey
/// levels that the same share of pixels does not reach belong together, whatever the noise. Tells
/// whether an image was really taken with the exposure time that it should have.
/// @param reference, image  of one scene that does not move; same type, one channel
/// @return  nothing where no grey level is neither dark nor saturated in both
/// @throws std::invalid_argument  empty, or of different types
std::optional<double> exposureRatio(const cv::Mat& reference, const cv::Mat& image,
                                    const HdrParams& params);

}  // namespace planar_bin_picking
