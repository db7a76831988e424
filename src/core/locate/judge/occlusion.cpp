// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/judge/occlusion.h"

#include "base/scatter.h"
#include "locate/judge/flat_face.h"

#include <opencv2/imgproc/detail/gcgraph.hpp>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr int kSamples = FaceGrid::kSamples;
// Weights of the outline per length of a cell's side, in units of what a border costs where nothing
// shows it. The edge of a free piece is hardly ever missed, but texture looks like the edge of many
// a piece that is covered.
constexpr float kSeen = 1.0f, kMissing = 3.0f;
// More than all else together: what lies outside the image is covered.
constexpr float kOutside = 1e3f;
constexpr double kTexture = 2.0;   // times the face's usual change from cell to cell: a border
constexpr double kFaintest = 3.0;  // grey levels per sample: usual changes are taken to be as large
// Cells from the outline to the middle of the cell within: half a cell's diagonal.
constexpr double kWithin = 0.7;

/// For each link, the strongest change between the middles of its cells.
std::vector<double> alongLinks(const FaceGrid& grid, const cv::Mat_<float>& change) {
  std::vector<double> strongest;
  strongest.reserve(grid.links().size());
  for (const FaceGrid::Link& link : grid.links()) {
    // The middle lies between two samples: a strip of both.
    const int x = kSamples * link.col + kSamples / 2 - 1,
              y = kSamples * link.row + kSamples / 2 - 1;
    float most = 0.0f;
    for (int k = 0; k <= kSamples + 1; ++k) {
      for (int side = 0; side < 2; ++side)
        most = std::max(most, link.along_x ? change(y + side, x + k) : change(y + k, x + side));
    }
    strongest.push_back(most);
  }
  return strongest;
}

/// Of the changes; zeros stand for what was not looked at.
double usual(std::vector<double> changes) {
  changes.erase(std::remove(changes.begin(), changes.end(), 0.0), changes.end());
  return std::max(kFaintest, median(std::move(changes)));
}

}  // namespace

std::vector<int> findOcclusion(const FaceGrid& grid, const FlatFace& flat,
                               const std::vector<OutlinePiece>& outline) {
  cv::Mat_<float> change = flat.change.clone();
  change.setTo(0.0f, grid.fromOutline() < kOwnLines);
  const auto changes = alongLinks(grid, change);
  const double border = kTexture * usual(changes);

  const int n = static_cast<int>(grid.cells().size());
  cv::detail::GCGraph<float> graph(n, static_cast<unsigned>(2 * grid.links().size()));
  for (int i = 0; i < n; ++i) graph.addVtx();
  for (const int i : flat.outside) graph.addTermWeights(i, 0.0f, kOutside);
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const double q = changes[i] / border;
    const auto cost = static_cast<float>(std::exp(-q * q));
    graph.addEdges(grid.links()[i].first, grid.links()[i].second, cost, cost);
  }
  for (const OutlinePiece& piece : outline) {
    const int cell = grid.cellNear(piece.position - kWithin * grid.cellSize() * piece.normal);
    if (cell < 0) continue;
    const auto share = static_cast<float>(piece.length / grid.cellSize());
    graph.addTermWeights(cell, piece.seen ? kSeen * share : 0.0f,
                         piece.seen ? 0.0f : kMissing * share);
  }
  graph.maxFlow();
  std::vector<int> covered;
  for (int i = 0; i < n; ++i)
    if (!graph.inSourceSegment(i)) covered.push_back(i);  // without any evidence a cell is free
  return covered;
}

}  // namespace planar_bin_picking
