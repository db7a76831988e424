# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""What pictures and answers of a cell say about it: numbers, each with its verdict and what to do. No ROS.

Grey levels are those of an 8-bit picture, 0..255, whatever the camera gives."""
import math

import cv2
import numpy

GOOD, LOOK, BAD = "GOOD", "LOOK", "BAD"

NOISE = (3.0, 8.0)  # grey levels: up to the first it is GOOD, beyond the second BAD
FLICKER = (2.0, 8.0)  # per cent of brightness from picture to picture
BLUR = (1.5, 3.0)  # px, standard deviation of what an edge is smeared by
SATURATED = (0.5, 5.0)  # per cent of the picture
BRIGHTEST = (100.0, 50.0)  # grey level that one pixel in a hundred exceeds
CONTRAST = (60.0, 30.0)  # between the darkest and the brightest hundredth
GLARE = (0.05, 1.0)  # per cent of the picture, the largest spot
SHARPEST = 0.3  # px; no pixel shows less
FEWEST = 300  # px of edges that the blur is told from; in a ninth of the picture 50
FULL = 254  # grey level of a pixel that may have been brighter


class Finding:
    """One number, and what it means."""

    def __init__(self, name, value, unit, verdict, advice=""):
        self.name, self.value, self.unit, self.verdict = name, value, unit, verdict
        self.advice = advice if verdict != GOOD else ""


def judged(name, value, unit, limits, advice):
    """A finding; limits that fall mean that more is better."""
    sign = 1.0 if limits[0] < limits[1] else -1.0
    verdict = GOOD if sign * value <= sign * limits[0] else LOOK if sign * value <= sign * limits[1] else BAD
    return Finding(name, value, unit, verdict, advice)


def grey_of(image):
    """Grey levels of an image message, as floats; None for an encoding that is not measured."""
    rows = numpy.frombuffer(image.data, numpy.uint8).reshape(image.height, image.step)
    encoding = image.encoding
    if encoding in ("mono8", "8UC1"):
        return rows[:, :image.width].astype(numpy.float32)
    if encoding in ("rgb8", "bgr8", "8UC3", "rgba8", "bgra8", "8UC4"):
        channels = 4 if "a8" in encoding or encoding == "8UC4" else 3
        pixels = rows[:, :channels * image.width].reshape(image.height, image.width, channels)
        return pixels[:, :, :3].astype(numpy.float32).mean(axis=2)
    if encoding.startswith("bayer_") and encoding.endswith("8"):
        even = rows[:image.height // 2 * 2, :image.width // 2 * 2].astype(numpy.float32)
        return (even[::2, ::2] + even[1::2, ::2] + even[::2, 1::2] + even[1::2, 1::2]) / 4.0
    if encoding in ("mono16", "16UC1"):
        words = rows[:, :2 * image.width].copy().view(">u2" if image.is_bigendian else "<u2").astype(numpy.float32)
        bits = next(bits for bits in (8, 10, 12, 14, 16) if words.max() < 2 ** bits)
        return words * (255.0 / (2 ** bits - 1))
    return None


def noise(pictures):
    """Of pictures of a still scene: what differs from one to the next."""
    levels = []
    for first, second in zip(pictures, pictures[1:]):
        difference = blocks((second - first) / math.sqrt(2.0))
        mean = blocks(first).mean(axis=1)
        lit = (mean > 10.0) & (mean < 245.0)
        if lit.any():
            levels.append(float(numpy.median(difference[lit].std(axis=1))))
    means = [float(picture.mean()) for picture in pictures]
    flicker = 100.0 * (max(means) - min(means)) / max(1.0, sum(means) / len(means))
    return [
        judged("noise", max(levels) if levels else 0.0, "grey levels", NOISE,
               "more light, a longer exposure or less gain; several pictures averaged by the driver"),
        judged("flicker", flicker, "% of brightness", FLICKER,
               "shield the cell from daylight, switch off the camera's automatic exposure, or expose for whole periods of "
               "the mains (10 or 20 ms at 50 Hz)")]


def blocks(picture, size=16):
    """One row for each square block."""
    rows, columns = picture.shape[0] // size, picture.shape[1] // size
    cut = picture[:rows * size, :columns * size].reshape(rows, size, columns, size)
    return cut.transpose(0, 2, 1, 3).reshape(rows * columns, size * size)


def slopes_of(picture):
    """Along x and along y, grey levels per pixel."""
    return (cv2.filter2D(picture, cv2.CV_32F, numpy.float32([[-0.5, 0, 0.5]])),
            cv2.filter2D(picture, cv2.CV_32F, numpy.float32([[-0.5], [0], [0.5]])))


def is_ridge(slope, along_x, along_y):
    """Where the slope is the largest across the edge; along the edge nothing is chosen, or noise would choose."""
    steep = 2.414  # tangent of 67.5 degrees
    ridge = numpy.zeros(slope.shape, bool)
    flat, upright = abs(along_x) > steep * abs(along_y), abs(along_y) > steep * abs(along_x)
    falling = ~flat & ~upright & (along_x * along_y > 0.0)
    rising = ~flat & ~upright & ~falling
    middle = slope[1:-1, 1:-1]
    for where, (dy, dx) in ((flat, (0, 1)), (upright, (1, 0)), (falling, (1, 1)), (rising, (1, -1))):
        rows, columns = slope.shape
        after = slope[1 + dy:rows - 1 + dy, 1 + dx:columns - 1 + dx]
        before = slope[1 - dy:rows - 1 - dy, 1 - dx:columns - 1 - dx]
        ridge[1:-1, 1:-1] |= where[1:-1, 1:-1] & (middle >= after) & (middle > before)
    return ridge


def edge_blurs_here(picture, noise_level):
    """x, y and blur in px of the steepest edges. A step smeared by s has a slope in proportion to 1 / s, smeared by
    s0 besides, to 1 / sqrt(s^2 + s0^2): the ratio of both tells s, whatever the contrast. Edges are looked for, and
    their direction taken, in the picture that is smeared besides: where noise alone is steep, it would pass for sharp."""
    besides = 2.0  # s0, px: more, and edges run into each other
    first = 0.5  # of the smoothing against noise
    smooth = cv2.GaussianBlur(picture, (0, 0), first)
    (sx, sy), (wx, wy) = slopes_of(smooth), slopes_of(cv2.GaussianBlur(smooth, (0, 0), besides))
    weaker = cv2.magnitude(wx, wy)
    # Of the noise, smeared by s0, 1 / (2 sqrt(2 pi) s0^2) is left in a slope.
    least = max(1.5, 5.0 * noise_level / (5.0 * besides ** 2))
    y, x = numpy.nonzero(is_ridge(weaker, wx, wy) & (weaker > least))
    slope = (sx[y, x] * wx[y, x] + sy[y, x] * wy[y, x]) / weaker[y, x]
    ratio = slope / weaker[y, x]
    smeared = besides / numpy.sqrt(numpy.maximum(ratio ** 2 - 1.0, 1e-3))
    # Without what the difference over two pixels and the smoothing add themselves.
    return x, y, numpy.sqrt(numpy.maximum(smeared ** 2 - 1.0 / 3.0 - first ** 2, SHARPEST ** 2))


def edge_blurs(picture, noise_level):
    """The same at the size of the picture at which the blur can be measured: wide ones are in a smaller one."""
    widest = 2.0  # px, s0
    x, y, blur = edge_blurs_here(picture, noise_level)
    if min(picture.shape) < 200 or (len(blur) >= FEWEST and numpy.median(blur) <= widest):
        return x, y, blur
    half = cv2.resize(picture, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    hx, hy, half_blur = edge_blurs(half, 0.5 * noise_level)
    return (2 * hx, 2 * hy, 2.0 * half_blur) if len(half_blur) >= FEWEST else (x, y, blur)


def focus(picture, noise_level=0.0):
    """The median of the edges, in the whole picture and in each ninth of it; 3 x 3, nan where there are too
    few."""
    x, y, blur = edge_blurs(picture, noise_level)
    ninths = numpy.full((3, 3), numpy.nan)
    for row in range(3):
        for column in range(3):
            here = (3 * y // picture.shape[0] == row) & (3 * x // picture.shape[1] == column)
            if here.sum() >= 50:
                ninths[row, column] = numpy.median(blur[here])
    if len(blur) < FEWEST:
        return [Finding("blur of edges", float("nan"), "px", LOOK,
                        "there are too few edges to tell: put parts into the bin")], ninths
    found = [judged("blur of edges", float(numpy.median(blur)), "px", BLUR,
                    "focus on the middle of the bin and lock the lens; look for a dirty window and for vibration")]
    if numpy.isfinite(ninths).sum() >= 4:
        found.append(judged("blur of the worst ninth", float(numpy.nanmax(ninths)), "px", (1.5 * BLUR[0], 1.5 * BLUR[1]),
                            "close the aperture for more depth of field, or put the camera upright over the bin"))
    return found, ninths


def exposure(picture):
    full = 100.0 * float((picture >= FULL).mean())
    darkest, brightest = (float(value) for value in numpy.percentile(picture, (1, 99)))
    return [
        judged("overexposed", full, "% of the picture", SATURATED, "expose shorter, or take brackets (HDR)"),
        judged("brightest hundredth", brightest, "grey level", BRIGHTEST, "more light or a longer exposure"),
        judged("contrast", brightest - darkest, "grey levels", CONTRAST,
               "light from the side or from all around; a floor that is darker or brighter than the parts")]


def glare(picture):
    """Spots that are full white, and a mask of them."""
    mask = cv2.morphologyEx((picture >= FULL).astype(numpy.uint8), cv2.MORPH_OPEN, numpy.ones((3, 3), numpy.uint8))
    _, _, statistics, _ = cv2.connectedComponentsWithStats(mask)
    areas = statistics[1:, cv2.CC_STAT_AREA]
    largest = 100.0 * float(areas.max()) / picture.size if len(areas) else 0.0
    return [judged("largest spot of glare", largest, "% of the picture", GLARE,
                   "diffuse light, a polarizer, the lamp out of the mirror direction, or brackets (HDR)")], mask


def camera_info(image, info):
    """Whether what the driver says of the camera can belong to this picture."""
    found = []

    def claim(holds, name, advice):
        found.append(Finding(name, "yes" if holds else "no", "", GOOD if holds else BAD, advice))

    claim(info.K[0] > 0.0 and info.K[4] > 0.0, "camera_info is calibrated", "calibrate the camera (doc/calibration.md)")
    roi = info.roi.width or info.width, info.roi.height or info.height
    size = [length // max(1, binning) for length, binning in zip(roi, (info.binning_x, info.binning_y))]
    claim(abs(size[0] - image.width) <= 2 and abs(size[1] - image.height) <= 2, "camera_info has the picture's size",
          f"camera_info is for {size[0]} x {size[1]} pixels, the picture has {image.width} x {image.height}: calibrate at this "
          "resolution, or set binning and region of interest in the driver")
    claim(image.header.stamp == info.header.stamp, "both have the same stamp", "mend the driver: pairs are found by their stamps")
    claim(image.header.frame_id == info.header.frame_id != "", "both have the same frame",
          f"the picture is in '{image.header.frame_id}', camera_info in '{info.header.frame_id}': set the driver's frame")
    if info.K[0] > 0.0 and info.width:
        centre = max(abs(info.K[2] / info.width - 0.5), abs(info.K[5] / info.height - 0.5))
        found.append(judged("principal point off the middle", 100.0 * centre, "% of the size", (10.0, 25.0),
                            "calibrate anew with views that fill the picture; or the picture is a cut-out that camera_info "
                            "does not know of"))
        found.append(judged("focal lengths differ", 100.0 * abs(info.K[4] / info.K[0] - 1.0), "%", (1.0, 5.0),
                            "calibrate anew: pixels are square"))
    return found


# --- answers -------------------------------------------------------------------------------------

def rotation(q):
    axis = numpy.array([q.x, q.y, q.z])
    angle = 2.0 * math.atan2(numpy.linalg.norm(axis), q.w)
    return cv2.Rodrigues(axis * (angle / max(1e-12, numpy.linalg.norm(axis))))[0]


class Track:
    """One part in all answers that have it."""

    def __init__(self, part):
        self.name, self.face = part.part, part.face
        self.positions, self.rotations, self.sigmas, self.scores = [], [], [], []
        self.add(part)

    def add(self, part):
        p = part.pose.pose.position
        self.positions.append([p.x, p.y, p.z])
        self.rotations.append(rotation(part.pose.pose.orientation))
        self.sigmas.append(numpy.sqrt(numpy.maximum(numpy.diag(numpy.reshape(part.pose.covariance, (6, 6))), 0.0)))
        self.scores.append(part.score)

    def position(self):
        return numpy.mean(self.positions, axis=0)

    def turns(self):
        """Rotation vectors about the fixed axes, from the first on, rad; those of symmetric copies left out."""
        vectors = [cv2.Rodrigues(R @ self.rotations[0].T)[0].ravel() for R in self.rotations]
        return numpy.array([vector for vector in vectors if numpy.linalg.norm(vector) < math.radians(20.0)])

    def deviations(self):
        """n x 6: mm and degrees off the mean."""
        turns = self.turns()
        n = len(turns)
        moves = 1e3 * (numpy.array(self.positions[:n]) - numpy.mean(self.positions[:n], axis=0))
        return numpy.hstack([moves, numpy.degrees(turns - turns.mean(axis=0))])


def tracks_of(answers, reach=0.01):
    """Which part is which from answer to answer: the nearest of its name and face within `reach`, m."""
    tracks = []
    for answer in answers:
        free = list(tracks)
        for part in answer.parts:
            p = part.pose.pose.position
            near = [(float(numpy.linalg.norm(track.position() - (p.x, p.y, p.z))), i, track)
                    for i, track in enumerate(free) if (track.name, track.face) == (part.part, part.face)]
            if near and min(near)[0] < reach:
                track = min(near)[2]
                free.remove(track)
                track.add(part)
            else:
                tracks.append(Track(part))
    return tracks


AXES = ("x, mm", "y, mm", "z, mm", "about x, deg", "about y, deg", "about z, deg")


def spread(tracks, count, limit_mm, limit_deg):
    """How far the answers to a scene that stands still lie apart; and all deviations, n x 6."""
    steady = [track for track in tracks if len(track.positions) >= max(2, 0.8 * count)]
    if not steady:
        return [Finding("parts that every answer has", 0, "", BAD, "no part is found again in four of five answers: look at "
                        "light, focus and exposure above, and at ~overlay")], numpy.zeros((0, 6))
    deviations = numpy.vstack([track.deviations() for track in steady])
    freedom = max(1, len(deviations) - len(steady))
    sigma = numpy.sqrt((deviations ** 2).sum(axis=0) / freedom)
    expected = numpy.median(numpy.vstack([s for track in steady for s in track.sigmas]), axis=0)
    expected = numpy.concatenate([1e3 * expected[:3], numpy.degrees(expected[3:])])
    found = [Finding("parts that every answer has", len(steady), "", GOOD)]
    rare = len(tracks) - len(steady)
    found.append(judged("parts that come and go", rare, "", (len(steady), 2 * len(steady)),
                        "what is found now and then scores near the threshold: raise score_min, or improve the light"))
    for axis, name in enumerate(AXES):
        limit = limit_mm if axis < 3 else limit_deg
        finding = judged(f"spread, {name}", float(sigma[axis]), f"(the answers expect {expected[axis]:.3f})",
                         (limit, 2.0 * limit), "see noise, flicker and blur above; is anything moving?")
        found.append(finding)
    return found, deviations


def hand_eye(first, second, limit_mm, limit_deg):
    """Parts that lie still, seen from two poses of the arm: where they seem to have gone to; rows (name, mm x 3, deg)."""
    rows = []
    for track in first:
        there = [(float(numpy.linalg.norm(other.position() - track.position())), i, other)
                 for i, other in enumerate(second) if (other.name, other.face) == (track.name, track.face)]
        if there and min(there)[0] < 0.05:
            other = min(there)[2]
            turn = cv2.Rodrigues(other.rotations[0] @ track.rotations[0].T)[0]
            rows.append((track.name, *(1e3 * (other.position() - track.position())),
                         math.degrees(float(numpy.linalg.norm(turn)))))
    if not rows:
        return [Finding("parts seen from both poses", 0, "", BAD, "no part is found again within 50 mm: the hand-eye "
                        "calibration is far off, tf and images have different times, or the parts were moved")], rows
    moved = numpy.median(numpy.linalg.norm(numpy.array([row[1:4] for row in rows]), axis=1))
    turned = numpy.median([row[4] for row in rows])
    advice = ("calibrate hand and eye anew, or hold the calibration against the cell with the calibrator's ~verify; check that the "
              "image's stamp is when it was exposed")
    return [Finding("parts seen from both poses", len(rows), "", GOOD),
            judged("they seem to move by", float(moved), "mm", (limit_mm, 2.0 * limit_mm), advice),
            judged("they seem to turn by", float(turned), "deg", (limit_deg, 2.0 * limit_deg), advice)], rows
