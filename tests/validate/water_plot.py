#!/usr/bin/python3
"""Draws docs/physics/water.svg and sampling.svg beside it from the files of
`make validate-water`: the share of the light of all orders that each answer
brings, sorted, over every geometry; and the error of the maps.

water_plot.py [FOLDER [DOCS]]
"""
import json
import math
import sys

WIDTH, HEIGHT, LEFT, TOP = 640, 360, 56, 20
PLOT_W, PLOT_H = WIDTH - LEFT - 150, HEIGHT - TOP - 50
LOW, HIGH = 0.05, 2.0
CURVES = [("all", "#0b5fa5", "all orders"), ("paper", "#c2410c", "the paper's form"),
          ("two", "#6b7280", "two orders")]


def place(share, ratio):
    ratio = min(max(ratio, LOW), HIGH)
    y = math.log(HIGH / ratio) / math.log(HIGH / LOW)
    return LEFT + share * PLOT_W, TOP + y * PLOT_H


def line(points, colour, width=2):
    path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return (f'<polyline points="{path}" fill="none" stroke="{colour}" '
            f'stroke-width="{width}"/>')


def text(x, y, words, anchor="start", colour="#111"):
    return (f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" '
            f'fill="{colour}">{words}</text>')


def draw_orders(source, target):
    with open(source) as f:
        rows = json.load(f)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" '
           f'height="{HEIGHT}" font-family="sans-serif" font-size="12">',
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>']
    for ratio in (0.05, 0.1, 0.2, 0.5, 1, 2):
        (x0, y), (x1, _) = place(0, ratio), place(1, ratio)
        out.append(line([(x0, y), (x1, y)], "#d1d5db", 1))
        out.append(text(x0 - 6, y + 4, f"{ratio:g}", "end"))
    for share in (0, 0.25, 0.5, 0.75, 1):
        x, y = place(share, LOW)
        out.append(text(x, y + 16, f"{100 * share:g} %", "middle"))
    out.append(text(LEFT + PLOT_W / 2, HEIGHT - 8,
                    f"share of {len(rows)} geometries", "middle"))
    for name, colour, words in CURVES:
        ratios = sorted(row[name] / row["montecarlo"] for row in rows)
        points = [place(i / (len(ratios) - 1), r) for i, r in enumerate(ratios)]
        out.append(line(points, colour))
        y = points[-1][1] + (4 if name == "all" else -6 if name == "paper" else 18)
        out.append(text(LEFT + PLOT_W + 8, y, words, colour=colour))
    out.append(text(LEFT, 14, "radiance leaving the water, of Monte Carlo's all orders"))
    out.append("</svg>\n")
    with open(target, "w") as f:
        f.write("\n".join(out))



STUDY = [("planes", "#0b5fa5", "planes, n_z"), ("zeniths", "#c2410c", "zeniths"),
         ("azimuths", "#15803d", "azimuths"), ("size", "#6b7280", "texels a side")]


def draw_sampling(source, target):
    """Error against each number of the sampling, both logarithmic."""
    with open(source) as f:
        study = json.load(f)
    least, most, first, last = 1e-4, 1.0, 2, 96

    def at(n, error):
        x = math.log(n / first) / math.log(last / first)
        y = math.log(most / max(error, least)) / math.log(most / least)
        return LEFT + x * PLOT_W, TOP + y * PLOT_H

    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" '
           f'height="{HEIGHT}" font-family="sans-serif" font-size="12">',
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>']
    for error, words in ((1, "1"), (0.1, "0.1"), (1 / 255, "1/255"),
                         (1e-3, "1/1000"), (1e-4, "1e-4")):
        (x0, y), (x1, _) = at(first, error), at(last, error)
        out.append(line([(x0, y), (x1, y)], "#d1d5db", 1))
        out.append(text(x0 - 6, y + 4, words, "end"))
    for n in (2, 4, 8, 16, 32, 64, 96):
        x, y = at(n, least)
        out.append(text(x, y + 16, str(n), "middle"))
    for i, (name, colour, words) in enumerate(STUDY):
        out.append(line([at(n, e) for n, e in study[name]], colour))
        made = study["made"][i]
        for n, e in study[name]:
            if n == made:
                x, y = at(n, e)
                out.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" '
                           f'fill="{colour}"/>')
        out.append(text(LEFT + PLOT_W + 8, TOP + 20 + 18 * i, words, colour=colour))
    out.append(text(LEFT, 14, "worst error of the maps, of the maximum; dots: as made"))
    out.append("</svg>\n")
    with open(target, "w") as f:
        f.write("\n".join(out))


def main():
    folder = sys.argv[1] if len(sys.argv) > 1 else "build/validate"
    target = sys.argv[2] if len(sys.argv) > 2 else "docs/physics"
    draw_orders(f"{folder}/water.json", f"{target}/water.svg")
    draw_sampling(f"{folder}/sampling.json", f"{target}/sampling.svg")


main()
