"""Small plots as SVG: panels of curves, each with its name and colour."""
import math

WIDE, HIGH, LEFT, TOP, RIGHT, BOTTOM = 250, 190, 52, 26, 8, 34
STYLES = {"reference": ("#111", "reference", ""), "ours": ("#0a6ebd", "ours", ""),
          "paper": ("#c2410c", "the paper's form", "4 3"),
          "cpu": ("#0a6ebd", "ours, C", ""),
          "gpu": ("#2e9e4f", "ours, shaders", "4 3")}


def ticks(low, high, log):
    if log:
        first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
        step = max(1, round((last - first) / 4))
        return [10.0 ** e for e in range(first, last + 1, step)
                if low <= 10.0 ** e <= high]
    step = 10 ** math.floor(math.log10((high - low) / 2))
    while (high - low) / step > 5:
        step *= 2
    first = math.ceil(low / step)
    return [i * step for i in range(first, int(high / step) + 1)]


def words(x, y, text, anchor="middle", colour="#111"):
    return (f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" '
            f'fill="{colour}">{text}</text>')


def panel(x0, y0, title, curves, log):
    """One field of curves: {name: [(x, y)]}."""
    points = [p for curve in curves.values() for p in curve
              if not log or p[1] > 0]
    wide, high = WIDE - LEFT - RIGHT, HIGH - TOP - BOTTOM
    left, top = x0 + LEFT, y0 + TOP
    out = [f'<rect x="{left}" y="{top}" width="{wide}" height="{high}" '
           'fill="none" stroke="#9ca3af"/>',
           words(left + wide / 2, top - 8, title)]
    if not points:
        return out
    low, most = min(y for _, y in points), max(y for _, y in points)
    low = max(low, most / 1e4) if log else min(low, 0)
    most = most if most > low else low + 1
    a, b = min(x for x, _ in points), max(x for x, _ in points)
    b = b if b > a else a + 1

    def at(x, y):
        share = (math.log(max(y, low) / low) / math.log(most / low) if log
                 else (y - low) / (most - low))
        return left + wide * (x - a) / (b - a), top + high * (1 - share)

    for value in ticks(low, most, log):
        _, y = at(a, value)
        out.append(f'<path d="M{left} {y:.1f}h{wide}" stroke="#e5e7eb"/>')
        out.append(words(left - 4, y + 4, f"{value:.3g}", "end"))
    for value in ticks(a, b, False):
        x, _ = at(value, low)
        out.append(words(x, top + high + 14, f"{value:g}"))
    for name, curve in curves.items():
        colour, _, dash = STYLES[name]
        path = " ".join("{:.1f},{:.1f}".format(*at(x, y)) for x, y in curve)
        out.append(f'<polyline points="{path}" fill="none" stroke="{colour}" '
                   f'stroke-width="1.5" stroke-dasharray="{dash}"/>')
    return out


def save(path, panels, xlabel, ylabel, columns=3, log=False):
    """panels: [(title, {name of STYLES: [(x, y)]})]."""
    lines = -(-len(panels) // columns)
    wide, high = columns * WIDE, lines * HIGH + 42
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide}" '
           f'height="{high}" font-family="sans-serif" font-size="11">',
           f'<rect width="{wide}" height="{high}" fill="#fff"/>']
    for i, (title, curves) in enumerate(panels):
        out += panel(i % columns * WIDE, i // columns * HIGH, title, curves,
                     log)
    x = 12
    for name in [n for n in STYLES if any(n in c and c[n]
                                          for _, c in panels)]:
        colour, text, _ = STYLES[name]
        out.append(words(x, high - 24, "— " + text, "start", colour))
        x += 120
    out.append(words(12, high - 8, f"{ylabel} over {xlabel}", "start"))
    with open(path, "w", encoding="utf-8") as f:
        f.write("\n".join(out + ["</svg>", ""]))
