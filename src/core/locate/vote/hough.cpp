// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/vote/hough.h"

#include "base/parallel.h"
#include "base/plane_pose.h"
#include "locate/vote/raster_points.h"
#include "locate/vote/vote_planes.h"
#include "part/part_extent.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <locale>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

constexpr int kYawSectors = 12;  // per tile, the best of each sector and face is kept

/// Foreshortening of the tilted shapes: each is this times the last. A view lies at most a tenth
/// from the nearest shape, 1.4 cells at a part's rim and less elsewhere.
constexpr double kShapeRatio = 0.8, kShapeReach = 0.1;
/// Azimuths of a tilted shape, 30 degrees apart or, where it is foreshortened more, 22.
constexpr int kAzimuths = 6, kAzimuthsSteep = 8;
constexpr double kSteep = 0.7;  // foreshortening, that is a tilt of 45 degrees
/// A shape stands for tilts some degrees off, so a candidate may lie beyond the limit and its part
/// within.
constexpr double kTiltSlackDeg = 6.0;
/// The two planes of a foreshortened view refine into each other where their normals are nearer
/// than this (6 degrees).
constexpr double kTiltsApart = 0.1;
constexpr double kHalfCellLeast = 1.0;  // field pixels: the field holds nothing finer

Eigen::Matrix2d turn(double angle) { return Eigen::Rotation2Dd(angle).toRotationMatrix(); }

/// Foreshortening f of the image-plane affine map and the azimuth of the axis that keeps its
/// length.
struct Shape {
  double f, azimuth;
};

/// How the part looks in the image, up to position.
struct View {
  Face face;
  int sector;
  double yaw, distance;
  Shape shape;

  /// Part x, y (metres) -> ideal image plane: s R(azimuth) diag(1, f) R(yaw - azimuth) F.
  Eigen::Matrix2d affine() const {
    const double flip = face == Face::kFront ? -1.0 : 1.0;
    return turn(shape.azimuth) * Eigen::Vector2d(1.0, shape.f).asDiagonal() *
           turn(yaw - shape.azimuth) * Eigen::Vector2d(1.0, flip).asDiagonal() / distance;
  }
};

/// The tolerances of neighbouring shapes touch.
std::vector<Shape> makeShapes(double tilt_max_deg) {
  std::vector<Shape> out = {{1.0, 0.0}};
  const double f_min = std::cos(tilt_max_deg * M_PI / 180.0);
  for (double f = kShapeRatio; f > f_min - kShapeReach; f *= kShapeRatio) {
    const int azimuths = f > kSteep ? kAzimuths : kAzimuthsSteep;
    for (int k = 0; k < azimuths; ++k) out.push_back({f, k * M_PI / azimuths});
  }
  return out;
}

int stepsOver(double span, double step) {
  return std::max(1, static_cast<int>(std::ceil(span / step)));
}

/// By how much cells and yaw steps are finer than those along the part's radius: where edges lie
/// near to one another (narrow webs, perforated plates, teeth), the next edge would confirm each
/// vote.
double finerBy(const PartModel& part, const HoughParams& params) {
  constexpr double kAcross = 3.5;  // cells from one edge to the next; most parts have as many
  constexpr double kMost = 3.0;    // the search takes the third power as long
  const double turn = 2.0 * M_PI / std::max(1, part.nearOrder());  // of a gear a tooth and a gap
  const double apart = std::min(meanWidthOf(part), turn * part.radius());
  return std::clamp(kAcross * part.radius() / apart / params.radius_cells, 1.0, kMost);
}

/// The views of a search before they are made: every face, distance, shape and yaw.
struct ViewGrid {
  std::vector<Face> faces;
  int distances, yaws;
  double span, yaw_range;  // of the distances' logarithm; rad
  std::vector<Shape> shapes;

  /// @param finer  steps of the yaw for each that the parameters say
  ViewGrid(const HoughTask& task, const HoughParams& params, double finer)
      : faces({Face::kFront}), shapes(makeShapes(params.tilt_max_deg)) {
    // The faces of a mirror symmetric outline look the same; a print tells them apart later
    // (print_evidence.h).
    if (!task.part->symmetry().mirror) faces.push_back(Face::kBack);
    const int order = task.part->nearOrder();
    yaw_range = order == 0 ? 0.0 : 2.0 * M_PI / order;
    yaws = stepsOver(yaw_range, params.yaw_step_deg / finer * M_PI / 180.0);
    span = std::log(task.distance_max / task.distance_min);
    distances = stepsOver(span, std::log(1.0 + params.distance_step));
  }
  double count() const {
    return static_cast<double>(faces.size() * shapes.size()) * distances * yaws;
  }
};

std::vector<View> makeViews(const ViewGrid& grid, double distance_min) {
  std::vector<View> out;
  for (const Face face : grid.faces) {
    for (int h = 0; h < grid.distances; ++h) {
      const double distance = distance_min * std::exp(grid.span * (h + 0.5) / grid.distances);
      for (const auto& shape : grid.shapes) {
        for (int k = 0; k < grid.yaws; ++k) {
          const int sector = (face == Face::kBack ? kYawSectors : 0) + k * kYawSectors / grid.yaws;
          out.push_back({face, sector, grid.yaw_range * k / grid.yaws, distance, shape});
        }
      }
    }
  }
  return out;
}

/// The raster points of all views as offsets into the planes, in one block: some thousand small
/// ones would cost the heap as much again.
struct Layouts {
  std::size_t points;
  std::vector<std::int32_t> offsets;  // [view][point], see Offsets
  std::vector<Range> ranges;          // [view]

  Layouts(std::size_t views, std::size_t points_of_each)
      : points(points_of_each), offsets(views * points_of_each), ranges(views) {}
  Offsets offsetsOf(std::size_t view) const {
    return {offsets.data() + view * points, static_cast<int>(points)};
  }
};

/// What a search would allocate is known before: parameters at the ends of their ranges multiply.
void checkMemory(const PartModel& part, const HoughParams& params, double views, double plane_bytes,
                 std::size_t points) {
  constexpr double kMost = 1e9;  // bytes: what a cell's computer can spare
  constexpr double kPerView = sizeof(View) + sizeof(Range);
  const double bytes = plane_bytes + views * (kPerView + points * sizeof(std::int32_t));
  if (bytes <= kMost) return;
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(3);
  text << "searching for part " << part.name() << " would take " << 1e-9 * bytes
       << " GB, more than 1 GB, with " << views << " views; make hough/yaw_step_deg ("
       << params.yaw_step_deg << ") or hough/distance_step (" << params.distance_step
       << ") larger, hough/tilt_max_deg or edges/megapixels smaller, or bring the distances nearer "
          "together";
  throw std::invalid_argument(text.str());
}

/// @param offset  of the view's first raster point; there is room for all
Range layOut(const RasterPoints& points, const Field& field, const VotePlanes& planes,
             const View& view, std::int32_t* offset) {
  const Eigen::Matrix2d A = view.affine();
  const Eigen::Matrix2d to_half = A * (field.focal / planes.half);
  const Eigen::Matrix2d to_normal = A.inverse().transpose();
  const Eigen::AlignedBox2d box = placePoints(points, to_half, to_normal, planes, offset);
  Range out;
  const Eigen::Vector2d lo = 0.5 * kInViewShare * box.min(), hi = 0.5 * kInViewShare * box.max();
  out.col0 = std::max(0, static_cast<int>(std::ceil(-lo.x())));
  out.row0 = std::max(0, static_cast<int>(std::ceil(-lo.y())));
  out.col1 = std::min(planes.cols, static_cast<int>(std::floor(planes.cols - hi.x())));
  out.row1 = std::min(planes.rows, static_cast<int>(std::floor(planes.rows - hi.y())));
  const std::size_t odd = out.col0 & 1;
  for (int i = 0; i < points.count; ++i)
    offset[i] = static_cast<std::int32_t>(planes.byteOf(odd + static_cast<std::size_t>(offset[i])));
  return out;
}

/// A bin of the accumulator.
struct Bin {
  int votes = 0, view = -1, row = 0, col = 0;
};

/// The best bins of a row of tiles, by tile and yaw sector; of equal ones that of the first view.
class TileRow {
 public:
  TileRow(const VotePlanes& planes, int tile, int floor)
      : tile_(tile), columns_(planes.cols / tile + 1), pitch_(columns_ * tile + kChunk) {
    bins_.resize(static_cast<std::size_t>(columns_) * 2 * kYawSectors);
    thresholds_.resize(2 * kYawSectors, PruningThresholds(pitch_, floor));
  }
  const PruningThresholds& thresholds(int sector) const { return thresholds_[sector]; }
  /// @pre above the threshold
  void add(const Bin& found, int sector) {
    const int column = found.col / tile_;
    Bin& best = bins_[static_cast<std::size_t>(sector) * columns_ + column];
    if (found.votes == best.votes && found.view >= best.view) return;
    best = found;
    // Of as many votes an earlier view may come in a later round.
    thresholds_[sector].set(column * tile_, tile_, found.votes - 1);
  }
  const std::vector<Bin>& bins() const { return bins_; }

 private:
  int tile_, columns_, pitch_;
  std::vector<Bin> bins_;
  std::vector<PruningThresholds> thresholds_;
};

/// Votes of one view for the centres in rows row0 to row1 of one row of tiles.
void vote(const VotePlanes& planes, const Layouts& layouts, int row0, int row1, int view,
          int sector, TileRow* tiles) {
  Range range = layouts.ranges[view];
  range.row0 = std::max(range.row0, row0);
  range.row1 = std::min(range.row1, row1);
  const PruningThresholds& thresholds = tiles->thresholds(sector);
  VoteScan scan(planes, layouts.offsetsOf(view), range);
  VoteScan::Chunks found;
  while (scan.next(thresholds, &found)) {
    for (const int right : {0, 1}) {
      const VoteScan::Chunk& chunk = found.chunks[right];
      const int col = found.col + right * kChunk, end = std::min(kChunk, range.col1 - col);
      // A bin on the left may have raised the thresholds of a tile that is in both.
      if (!chunk.is_found || (right && !thresholds.anyGoesOn(chunk.first.data(), col))) continue;
      for (int i = 0; i < end; ++i) {
        if (!chunk.is_enough[i] || chunk.all[i] <= thresholds.best(col + i)) continue;
        tiles->add({chunk.all[i], view, found.row, col + i}, sector);
      }
    }
  }
}

/// Views whose index leaves this remainder, looked at in one round.
struct Round {
  std::size_t divisor, remainder;
};
/// A few views from all over first: what they find tells how many votes it takes to be among the
/// candidates, and saves most of the work on the rest.
constexpr std::array<Round, 4> kRounds = {{{8, 0}, {8, 4}, {4, 2}, {2, 1}}};

/// The best bins of all tiles, row of tiles after row.
using Bins = std::vector<std::vector<Bin>>;

/// Looks at more views.
/// @param floor  votes of a bin at least; of those before only bins that have as many are left
void lookAt(const Round& round, const VotePlanes& planes, const std::vector<View>& views,
            const Layouts& layouts, int floor, int tile, int threads, Bins* bins) {
  parallelFor(static_cast<int>(bins->size()), threads, [&](int r) {
    std::vector<Bin>& found = (*bins)[static_cast<std::size_t>(r)];
    TileRow tiles(planes, tile, floor);
    for (const Bin& b : found)
      if (b.votes >= floor) tiles.add(b, views[b.view].sector);
    for (std::size_t v = round.remainder; v < views.size(); v += round.divisor)
      vote(planes, layouts, r * tile, (r + 1) * tile, static_cast<int>(v), views[v].sector, &tiles);
    found.clear();
    for (const Bin& b : tiles.bins())
      if (b.view >= 0) found.push_back(b);
  });
}

/// Most votes first; of equal ones in the order of the rows.
std::vector<Bin> sorted(const Bins& bins, int floor) {
  std::vector<Bin> out;
  for (const auto& row : bins)
    std::copy_if(row.begin(), row.end(), std::back_inserter(out),
                 [floor](const Bin& b) { return b.votes >= floor; });
  std::stable_sort(out.begin(), out.end(),
                   [](const Bin& a, const Bin& b) { return a.votes > b.votes; });
  return out;
}

/// Votes that so many bins have at least; `floor` where there are fewer.
int votesOf(int count, const Bins& bins, int floor) {
  std::array<int, kMaxPoints * kMaxVote + 1> by_votes{};
  for (const auto& row : bins)
    for (const Bin& b : row) ++by_votes[b.votes];
  for (int votes = kMaxPoints * kMaxVote; votes > floor; --votes) {
    count -= by_votes[votes];
    if (count <= 0) return votes;
  }
  return floor;
}

/// A foreshortened view is that of two planes.
void addCandidates(const Bin& bin, const View& view, const HoughTask& task,
                   const HoughParams& params, const Field& field, const VotePlanes& planes,
                   double most, std::vector<Candidate>* out) {
  const Eigen::Vector2d p((bin.col * 2 * planes.half - field.cx) / field.focal,
                          (bin.row * 2 * planes.half - field.cy) / field.focal);
  const auto poses = posesFromAffine(view.affine(), p);
  for (int k = 0; k < 2; ++k) {
    const double tilt = std::acos(std::min(1.0, std::abs(poses[k].linear()(2, 2))));
    if (tilt > (params.tilt_max_deg + kTiltSlackDeg) * M_PI / 180.0) continue;
    const double apart = (poses[0].linear().col(2) - poses[1].linear().col(2)).norm();
    if (k == 1 && apart < kTiltsApart) continue;
    Candidate c;
    c.part = task.part_index;
    c.face = view.face;
    c.votes = bin.votes / most;
    const Eigen::Vector2d& centre = task.part->center();
    c.T_camera_part =
        poses[k] * Eigen::Translation3d(-centre.x(), -centre.y(), -task.part->faceZ(view.face));
    out->push_back(c);
  }
}

/// The candidates of the best bins.
struct Best {
  std::vector<Candidate> candidates;
  int floor;  ///< votes that it took to be one of them
};

/// @param floor  votes of a bin at least
Best bestOf(const Bins& bins, const std::vector<View>& views, const HoughTask& task,
            const HoughParams& params, const Field& field, const VotePlanes& planes, double most,
            int floor) {
  Best out;
  // Nearly always as many bins are enough; few of these give none.
  for (const int least : {votesOf(params.max_candidates, bins, floor), floor}) {
    out = {{}, floor};
    int last = floor;
    for (const Bin& bin : sorted(bins, least)) {
      // A bin gives up to two candidates, and the limit holds for both.
      if (out.candidates.size() + 2 > static_cast<std::size_t>(params.max_candidates)) {
        out.floor = last;
        return out;
      }
      addCandidates(bin, views[bin.view], task, params, field, planes, most, &out.candidates);
      last = bin.votes;
    }
  }
  return out;
}

}  // namespace

std::vector<Candidate> findCandidates(const EdgeMap& edges, const HoughTask& task,
                                      const HoughParams& params, int threads) {
  const Field& field = edges.fieldOf(task.part_index);
  const double distance = std::sqrt(task.distance_min * task.distance_max);
  const double radius_px = field.focal * task.part->radius();
  const double finer = finerBy(*task.part, params);
  const double half =
      std::max(kHalfCellLeast, 0.5 * radius_px / distance / (finer * params.radius_cells));
  VotePlanes planes = sizePlanes(field, half, radius_px / task.distance_min);
  const RasterPoints points(*task.part, params.raster_points);
  const ViewGrid grid(task, params, finer);
  checkMemory(*task.part, params, grid.count(), static_cast<double>(planes.bytes()), points.count);
  fillPlanes(field, params.tolerance_cells * 2 * half, threads, &planes);
  const auto views = makeViews(grid, task.distance_min);
  Layouts layouts(views.size(), points.count);
  parallelFor(static_cast<int>(views.size()), threads, [&](int v) {
    layouts.ranges[v] =
        layOut(points, field, planes, views[v], &layouts.offsets[v * layouts.points]);
  });

  const double most = kMaxVote * static_cast<double>(points.count);
  // Slender parts lie side by side within one radius; each needs a tile of its own.
  const int tile = std::max(
      1,
      static_cast<int>(std::lround(params.tile_cells * grainOf(*task.part) / task.part->radius())));
  Bins bins(static_cast<std::size_t>((planes.rows + tile - 1) / tile));
  Best best{{}, static_cast<int>(std::ceil(params.votes_min * most))};
  for (const Round& round : kRounds) {
    lookAt(round, planes, views, layouts, best.floor, tile, threads, &bins);
    // Bins only get more votes: what is too few now stays too few.
    best = bestOf(bins, views, task, params, field, planes, most, best.floor);
  }
  return best.candidates;
}

}  // namespace planar_bin_picking
