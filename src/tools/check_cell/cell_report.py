# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""The report of check_cell.py: one HTML file with its pictures in it."""
import base64
import html
import math

import cv2
import numpy

from cell_measures import AXES, BAD, GOOD, LOOK

STYLE = """body { font: 16px/1.45 sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; color: #222; }
table { border-collapse: collapse; width: 100%; margin: 0.5em 0 1.5em; }
td, th { text-align: left; vertical-align: top; padding: 0.35em 0.7em; border-bottom: 1px solid #ddd; }
td.number { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; }
.GOOD { color: #186a2b; } .LOOK { color: #8a5a00; } .BAD { color: #a11; } .verdict { font-weight: bold; white-space: nowrap; }
img { max-width: 100%; border: 1px solid #ddd; } figure { margin: 1em 0; } figcaption { color: #555; }"""
WORST = {GOOD: "Nothing speaks against this cell.", LOOK: "The cell works, and could be better: look at what is marked LOOK.",
         BAD: "Something is wrong: see what is marked BAD."}
WHITE, GREY, BLUE, RED = (255, 255, 255), (200, 200, 200), (150, 90, 20), (0, 0, 220)


def verdict(findings):
    verdicts = {finding.verdict for finding in findings}
    return next(one for one in (BAD, LOOK, GOOD) if one in verdicts or one == GOOD)


def number(value):
    if not isinstance(value, float):
        return str(value)
    if math.isnan(value):
        return "–"
    return f"{round(value, 4):.3g}" if abs(value) < 100 else f"{value:.0f}"


def bars(counts, title, ticks, size=(360, 200)):
    """A histogram as a picture."""
    width, height = size
    picture = numpy.full((height, width, 3), 255, numpy.uint8)
    left, right, top, bottom = 12, width - 12, 34, height - 28
    peak = max(1, max(counts))
    edges = numpy.linspace(left, right, len(counts) + 1).astype(int)
    for i, count in enumerate(counts):
        top_of_bar = int(bottom - (bottom - top) * count / peak)
        cv2.rectangle(picture, (int(edges[i]), top_of_bar), (int(edges[i + 1]) - 1, bottom), BLUE, -1)
    cv2.line(picture, (left, bottom), (right, bottom), (80, 80, 80), 1)
    cv2.putText(picture, title, (left, 20), cv2.FONT_HERSHEY_SIMPLEX, 0.5, (30, 30, 30), 1, cv2.LINE_AA)
    for share, text in ticks:
        room = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, 0.4, 1)[0][0]
        x = int(min(max(left, left + share * (right - left) - room / 2), right - room))
        cv2.putText(picture, text, (x, height - 8), cv2.FONT_HERSHEY_SIMPLEX, 0.4, (80, 80, 80), 1, cv2.LINE_AA)
    return picture


def deviation_histograms(deviations):
    """Six in a picture, one for each axis."""
    panels = []
    for axis, name in enumerate(AXES):
        values = deviations[:, axis]
        reach = max(0.001, float(numpy.abs(values).max())) if len(values) else 1.0
        counts, _ = numpy.histogram(values, bins=21, range=(-reach, reach))
        panels.append(bars(counts, name, [(0.0, f"-{reach:.3g}"), (0.5, "0"), (1.0, f"{reach:.3g}")]))
    return numpy.vstack([numpy.hstack(panels[:3]), numpy.hstack(panels[3:])])


def grey_histogram(picture):
    counts, _ = numpy.histogram(picture, bins=64, range=(0, 256))
    return bars(counts, "grey levels", [(0.0, "0"), (0.5, "128"), (1.0, "255")], (540, 200))


def marked(picture, ninths, mask, width=1000):
    """The camera's picture with the blur of its ninths and the glare."""
    colour = cv2.cvtColor(numpy.clip(picture, 0, 255).astype(numpy.uint8), cv2.COLOR_GRAY2BGR)
    colour[mask > 0] = RED
    scale = width / colour.shape[1]
    colour = cv2.resize(colour, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    rows, columns = colour.shape[:2]
    for i in range(3):
        for j in range(3):
            text = "few edges" if math.isnan(ninths[i, j]) else f"{ninths[i, j]:.1f} px"
            at = (j * columns // 3 + 12, i * rows // 3 + 26)
            cv2.putText(colour, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.7, (0, 0, 0), 4, cv2.LINE_AA)
            cv2.putText(colour, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.7, (90, 255, 255), 1, cv2.LINE_AA)
        if i:
            cv2.line(colour, (i * columns // 3, 0), (i * columns // 3, rows), GREY, 1)
            cv2.line(colour, (0, i * rows // 3), (columns, i * rows // 3), GREY, 1)
    return colour


def png(picture):
    done, data = cv2.imencode(".png", picture)
    if not done:
        raise RuntimeError("a picture of the report cannot be encoded as PNG")
    return data.tobytes()


def table(findings):
    rows = "".join(
        f'<tr><td>{html.escape(f.name)}</td><td class="number">{html.escape(number(f.value))}</td><td>{html.escape(f.unit)}</td>'
        f'<td class="verdict {f.verdict}">{f.verdict}</td><td>{html.escape(f.advice)}</td></tr>' for f in findings)
    return f"<table><tr><th>What</th><th>Value</th><th></th><th>Verdict</th><th>What to do</th></tr>{rows}</table>"


def figure(picture, caption):
    data = base64.b64encode(png(picture)).decode()
    return f'<figure><img alt="{html.escape(caption)}" src="data:image/png;base64,{data}"><figcaption>{html.escape(caption)}</figcaption></figure>'


def moves_table(rows):
    head = "<tr><th>Part</th><th>x, mm</th><th>y, mm</th><th>z, mm</th><th>turn, deg</th></tr>"
    body = "".join(f"<tr><td>{html.escape(name)}</td>" + "".join(f'<td class="number">{value:.2f}</td>' for value in values) +
                   "</tr>" for name, *values in rows)
    return f"<table>{head}{body}</table>"


def page(title, facts, sections):
    """sections: [(heading, text, findings, [html])]."""
    findings = [finding for _, _, some, _ in sections for finding in some]
    overall = verdict(findings)
    body = "".join(f"<h2>{html.escape(heading)}</h2><p>{html.escape(text)}</p>{table(some) if some else ''}{''.join(more)}"
                   for heading, text, some, more in sections)
    told = "".join(f"<tr><td>{html.escape(key)}</td><td>{html.escape(str(value))}</td></tr>" for key, value in facts)
    return (f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title>'
            f"<style>{STYLE}</style></head><body><h1>{html.escape(title)}</h1>"
            f'<p class="verdict {overall}">{overall}: {WORST[overall]}</p><table>{told}</table>{body}</body></html>\n')
