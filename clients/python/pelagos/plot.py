"""Plots of what Pelagos says in numbers, by matplotlib, as SVG or PNG.

    pelagos-plot rrs|brdf|rose|height|rows FILE.svg|FILE.png

reads what it draws from standard input: a series as JSON (/v1/series, or
{"series": [...]} of several), of `rows` a picture as OpenEXR. `pelagosctl plot`
asks pelagosd and calls it. Title, question and version are in the file's
metadata."""
from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from typing import Any

from .errors import MissingPackage
from .exr import Exr, read_exr
from .schema import VERSION
from .series import Series

GREY = "#5a6570"
COLOURS = ("#0b6fa4", "#d9822b", "#3a8f5c", "#b3446c", "#7a5ab5", "#8c6d46")
# Of light at 680, 550 and 440 nm.
BANDS = ((680, "#c0392b"), (550, "#2e8b57"), (440, "#2c5fb3"))
STYLE = {
    "figure.figsize": (8.0, 5.2), "figure.dpi": 150, "font.size": 10.5,
    "font.family": ["DejaVu Sans", "sans-serif"], "svg.fonttype": "none",
    "svg.hashsalt": "pelagos", "axes.titlelocation": "left",
    "axes.titlesize": 14, "axes.titleweight": "bold", "axes.labelcolor": GREY,
    "axes.edgecolor": "#b8c0c7", "axes.linewidth": 0.8, "xtick.color": GREY,
    "ytick.color": GREY, "axes.grid": True, "grid.color": "#e3e8ec",
    "grid.linewidth": 0.7, "axes.axisbelow": True, "lines.linewidth": 1.8,
    "legend.frameon": False, "legend.fontsize": 9.5,
    "axes.spines.top": False, "axes.spines.right": False,
}
SUBJECTS = {"sunElevation": ("Sun’s elevation", "°"),
            "sunZenith": ("Sun’s zenith angle", "°"),
            "windSpeed": ("wind", " m/s"), "chlorophyll": ("chlorophyll",
                                                           " mg/m³"),
            "viewZenith": ("view’s zenith angle", "°"),
            "depth": ("depth", " m"), "salinity": ("salinity", " g/kg"),
            "cdom": ("CDOM", " 1/m"), "minerals": ("minerals", " g/m³")}


class Unfit(ValueError):
    """The series lacks what the plot shows."""


def _matplotlib() -> Any:
    try:
        import matplotlib
    except ImportError:
        raise MissingPackage("plots need matplotlib: apt install "
                             "python3-matplotlib, or pip install matplotlib"
                             ) from None
    matplotlib.use("Agg")
    import matplotlib.pyplot
    matplotlib.rcParams.update(STYLE)
    return matplotlib


def _figure(title: str, about: str, **more: Any) -> tuple[Any, Any]:
    plt = _matplotlib().pyplot
    figure, axes = plt.subplots(layout="constrained", **more)
    # Lines of the head and of the foot, in inches.
    _, height = figure.get_size_inches()
    figure.get_layout_engine().set(rect=(0, 0.25 / height, 1,
                                         1 - 0.95 / height))
    figure.text(0.013, 1 - 0.10 / height, title, ha="left", va="top",
                fontsize=14, fontweight="bold")
    figure.text(0.013, 1 - 0.42 / height, about, ha="left", va="top",
                color=GREY, fontsize=10)
    return figure, axes


def _need(series: Series, *names: str) -> None:
    lacking = [n for n in names
               if n not in series.axes and n not in series.variables]
    if lacking:
        raise Unfit(f"this series has no {', '.join(lacking)}, which the plot "
                    f"shows; it has {', '.join([*series.axes, *series.variables])}")


def _outer(series: Series, *inner: str) -> tuple[str, Any]:
    """The axis that is neither of these: a line for each of its values."""
    rest = [a for a in series.axes if a not in inner]
    if len(rest) > 1:
        raise Unfit(f"the plot has room for one axis beside {', '.join(inner)}, "
                    f"not for {', '.join(rest)}")
    return (rest[0], series.axes[rest[0]]) if rest else ("", [None])


def _value(name: str, value: float, series: Series) -> str:
    word, unit = SUBJECTS.get(name, (name, " " + series.units[name]))
    return f"{word} {value:g}{unit}"


def _colours(count: int) -> Sequence[Any]:
    if count <= len(COLOURS):
        return COLOURS[:count]
    colours = _matplotlib().colormaps["viridis"]
    return [colours(0.92 * i / (count - 1)) for i in range(count)]


def _patched(series: Series, section: str, name: str) -> Any:
    """A number of the state, as the question has changed it."""
    query: Any = next(iter(
        v for k, v in series.query.items() if k in ("optics", "spectrum",
                                                    "surface")))
    patch = query.get("patch", {}).get("state", {})
    return patch.get(section, {}).get(
        name, series.state.get(section, {}).get(name))


def _sea(series: Series) -> str:
    spectrum = str(_patched(series, "sea", "spectrum") or "").replace("_", "–")
    words = spectrum.title() if "–" in spectrum else spectrum
    return f"{words}, wind {_patched(series, 'sea', 'windSpeed') or 0:g} m/s"


def rrs(series: Series) -> Any:
    """Remote-sensing reflectance over wavelength."""
    _need(series, "wavelength", "remoteSensingReflectance")
    name, values = _outer(series, "wavelength")
    question = series.query["optics"]["water"]
    parts = [f"Sun {question.get('sunZenith', 30):g}° and eye "
             f"{question.get('viewZenith', 0):g}° from the vertical"]
    if name != "chlorophyll" and _patched(series, "water", "chlorophyll"):
        parts.append("chlorophyll "
                     f"{_patched(series, 'water', 'chlorophyll'):g} mg/m³")
    if name != "depth":
        parts.append(f"depth {_patched(series, 'water', 'depth'):g} m")
    figure, axes = _figure("Remote-sensing reflectance of the water",
                           " · ".join(parts))
    over = series.dims["remoteSensingReflectance"]
    rows = series["remoteSensingReflectance"]
    if len(over) == 2 and over[0] == "wavelength":
        rows = rows.T
    rows = rows.reshape(len(values), -1)
    for row, value, colour in zip(rows, values, _colours(len(values))):
        axes.plot(series["wavelength"], row * 1e3, color=colour,
                  label=_value(name, value, series) if name else "Rrs")
    axes.set_xlabel("wavelength λ [nm]")
    axes.set_ylabel("Rrs(λ) = Lw / Ed  [10⁻³ sr⁻¹]")
    axes.set_xlim(series["wavelength"][0], series["wavelength"][-1])
    axes.set_ylim(bottom=0)
    axes.legend()
    return figure


def brdf(series: Series) -> Any:
    """The lobe of the reflected Sun in the plane of the Sun."""
    _need(series, "viewAzimuth", "viewZenith", "brdf")
    np = __import__("numpy")
    name, values = _outer(series, "viewAzimuth", "viewZenith")
    if len(series["viewAzimuth"]) != 2:
        raise Unfit("a lobe has two azimuths: away from the Sun and towards it")
    order = [series.dims["brdf"].index(a)
             for a in ([name] if name else []) + ["viewAzimuth", "viewZenith"]]
    lobes = series["brdf"].transpose(order).reshape(
        len(values), 2, len(series["viewZenith"]))
    wind = _patched(series, "sea", "windSpeed")
    sun = (0 if name == "sunElevation" else
           round(float(series["sunElevation"].flat[0]), 1))
    figure, axes = _figure(
        "How the sea reflects the Sun: BRDF in the Sun’s plane",
        ("" if name == "windSpeed" else f"wind {wind:g} m/s · ") +
        ("marks on the rim: the Sun" if name == "sunElevation" else
         f"Sun {sun:g}° above the horizon") + " · 550 nm · logarithmic radius",
        subplot_kw={"projection": "polar"}, figsize=(8.0, 5.3))
    figure.set_layout_engine("none")
    # The half disc is the middle of a square of 6.6 inches.
    axes.set_position((0.0875, -0.165, 0.825, 6.6 / 5.3))
    zenith = np.radians(series["viewZenith"])
    top = 10 ** np.ceil(np.log10(np.nanmax(lobes)))
    floor = top * 1e-6
    angles = np.concatenate([-zenith[::-1], zenith])
    for lobe, value, colour in zip(lobes, values, _colours(len(values))):
        # Towards the Sun on the right, where the glitter is.
        whole = np.concatenate([lobe[1][::-1], lobe[0]])
        radius = np.log10(np.maximum(whole, floor) / floor)
        label = _value(name, value, series) if name else "BRDF"
        axes.plot(angles, radius, color=colour, label=label)
        axes.fill(np.concatenate([angles, [0]]),
                  np.concatenate([radius, [0]]), color=colour, alpha=0.25 / max(len(values), 2))
        if name == "sunElevation":
            axes.plot([np.radians(value - 90)] * 2, [5.75, 6.05],
                      color=colour, linewidth=3, clip_on=False,
                      solid_capstyle="butt")
    axes.set_theta_zero_location("N")
    axes.set_theta_direction(-1)
    axes.set_thetamin(-90)
    axes.set_thetamax(90)
    axes.set_thetagrids(range(-90, 91, 15),
                        [f"{abs(a)}°" for a in range(-90, 91, 15)])
    axes.set_ylim(0, 6)
    axes.set_yticks(range(1, 7))
    exponents = [round(np.log10(floor)) + i for i in range(1, 7)]
    axes.set_yticklabels([rf"$10^{{{e}}}$" if i % 2 else "" for i, e in
                          enumerate(exponents)], fontsize=8.5)
    axes.spines["polar"].set_visible(False)
    figure.text(0.5, 0.055, "zenith angle of the eye [°] · BRDF [sr⁻¹] · left: "
                "back to the Sun, right: looking into the glitter", ha="center",
                color=GREY, fontsize=10)
    figure.legend(loc="upper right", bbox_to_anchor=(0.99, 0.93))
    return figure


def rose(series: Series) -> Any:
    """The directional spectrum, frequency outwards."""
    _need(series, "omega", "theta", "directional", "density")
    np = __import__("numpy")
    if series["directional"].ndim != 2:
        raise Unfit("a rose is of one spectrum, without axes")
    s = np.maximum(series["directional"], 0)
    omega = series["omega"]
    frequency = omega / (2 * np.pi)
    strong = np.nonzero(series["density"] > 0.02 * series["density"].max())[0]
    if len(strong) < 2:
        raise Unfit("there are no waves to show")
    last = frequency[min(strong[-1] + 1, len(omega) - 1)]
    height = float(series["spectrum_significantHeight"])
    parts = [f"Hs {height:.2f} m"]
    if "peakPeriod" in series.variables:
        parts.append(f"Tp {float(series['peakPeriod']):.2f} s")
    if "meanDirection" in series.variables:
        parts.append(f"mean direction {float(series['meanDirection']):.0f}°")
    parts.append(_sea(series))
    figure, axes = _figure("Directional spectrum of the sea",
                           " · ".join(parts), figsize=(7.4, 6.8),
                           subplot_kw={"projection": "polar"})
    theta = np.radians(np.append(series["theta"], 360))
    closed = np.concatenate([s, s[:, :1]], axis=1)
    levels = _matplotlib().ticker.MaxNLocator(12).tick_values(0, closed.max())
    fill = axes.contourf(theta, frequency, closed, levels=levels[1:],
                         cmap="viridis_r")
    axes.contour(theta, frequency, closed, levels=levels[1:], colors="white",
                 linewidths=0.4)
    axes.set_theta_zero_location("N")
    axes.set_theta_direction(-1)
    axes.set_thetagrids(range(0, 360, 30),
                        ["N", "30°", "60°", "E", "120°", "150°", "S", "210°",
                         "240°", "W", "300°", "330°"])
    axes.set_ylim(0, last)
    axes.set_rlabel_position(_quiet(series["theta"], s.sum(0)))
    axes.yaxis.set_major_locator(_matplotlib().ticker.MaxNLocator(4, prune="lower"))
    axes.yaxis.set_major_formatter("{x:g} Hz")
    axes.tick_params(axis="y", labelsize=8.5)
    axes.spines["polar"].set_visible(False)
    bar = figure.colorbar(fill, ax=axes, shrink=0.8, pad=0.09, format="%.3g")
    bar.set_label("S(ω, θ) of waves that come from θ  [m² s rad⁻²]")
    bar.outline.set_visible(False)
    return figure


def _quiet(theta: Any, energy: Any) -> float:
    """Where labels hide nothing: opposite the most energy, between the ticks."""
    return float((theta[energy.argmax()] + 180) % 360 // 30 * 30 + 15)


def height(series: Series, spectrum: Series | None = None) -> Any:
    """Heights at a place over time, and four standard deviations of them."""
    _need(series, "time", "height")
    np = __import__("numpy")
    time, heights = series["time"], series["height"]
    point = list(series.axes).index("point") if "point" in series.axes else None
    if point is not None and heights.shape[-1] > 1:
        heights = heights[..., 0]
    heights = heights.reshape(-1)
    window = min(len(time), max(8, round(len(time) / 5)))
    length = window * (time[-1] - time[0]) / max(len(time) - 1, 1)
    moved = np.lib.stride_tricks.sliding_window_view(heights, window)
    middle = time[:len(moved)] + 0.5 * (time[window - 1] - time[0])
    wanted = (float(spectrum["spectrum_significantHeight"])
              if spectrum else None)
    place = (f"{series['east'].flat[0]:g} m east, "
             f"{series['north'].flat[0]:g} m north")
    figure, (upper, lower) = _figure(
        "Height of the surface", f"{_sea(series)} · at {place} of the "
        "origin", nrows=2, sharex=True, height_ratios=(2, 1),
        figsize=(9.0, 5.6))
    upper.axhline(0, color="#b8c0c7", linewidth=0.8)
    upper.plot(time, heights, color=COLOURS[0], linewidth=1.1)
    upper.set_ylabel("height [m]")
    lower.plot(middle, 4 * moved.std(axis=1), color=COLOURS[1],
               label=f"4 σ of {length:.0f} s")
    lower.axhline(4 * heights.std(), color=COLOURS[2], linestyle=(0, (4, 2)),
                  linewidth=1.2, label=f"4 σ of all: {4 * heights.std():.2f} m")
    if wanted is not None:
        lower.axhline(wanted, color=GREY, linewidth=1.2, linestyle=":",
                      label=f"of the spectrum: {wanted:.2f} m")
    lower.set_ylabel("Hs [m]")
    lower.set_ylim(bottom=0)
    lower.set_xlabel("simulated time [s]")
    lower.set_xlim(time[0], time[-1])
    lower.legend(loc="lower right", ncols=3)
    return figure


def rows(picture: Exr) -> Any:
    """Radiance by rows of a picture: mean, and where nine of ten pixels are."""
    np = __import__("numpy")
    radiance = picture.layers.get("radiance")
    if radiance is None or radiance.ndim != 3:
        raise Unfit("the picture has no radiance")
    a = {k.removeprefix("pelagos."): v for k, v in picture.attributes.items()}
    pitch = float(a.get("pitch", 0))
    edges = np.array([float(a.get("tanTop", 0)), float(a.get("tanBottom", 0))])
    middle = (np.arange(picture.height) + 0.5) / picture.height
    elevation = pitch + np.degrees(np.arctan(
        edges[0] + (edges[1] - edges[0]) * middle))
    known = bool(np.ptp(edges))
    figure, axes = _figure(
        "Radiance by rows of the picture",
        f"view {a.get('view', '?')} at {float(a.get('time', 0)):.2f} s · "
        f"heading {round(float(a.get('heading', 0)), 1) % 360:.1f}° · shaded: 5 to 95 % of the "
        "row’s pixels", figsize=(7.6, 6.4))
    where = elevation if known else np.arange(picture.height)
    for k, (wavelength, colour) in enumerate(BANDS):
        band = radiance[..., k]
        low, high = np.percentile(band, [5, 95], axis=1)
        axes.fill_betweenx(where, low, high, color=colour, alpha=0.15,
                           linewidth=0)
        axes.plot(band.mean(axis=1), where, color=colour,
                  label=f"{wavelength} nm")
    if radiance.min() > 0 and radiance.max() > 30 * np.median(radiance):
        axes.set_xscale("log")
    axes.set_ylim((where[-1], where[0]) if known else (picture.height, 0))
    axes.set_xlabel("radiance  [W m⁻² sr⁻¹ nm⁻¹]")
    axes.set_ylabel("elevation of the row’s middle [°]" if known else
                    "row, from above")
    if known and where.min() < 0 < where.max():
        axes.axhline(0, color=GREY, linewidth=0.8, linestyle=":")
        axes.annotate("level", (1, 0), xycoords=("axes fraction", "data"),
                      ha="right", va="bottom", color=GREY, fontsize=9)
    axes.legend()
    return figure


def save(figure: Any, path: str, title: str, query: str) -> None:
    """Into an SVG or PNG, with title, question and version as metadata."""
    program = f"pelagos {VERSION}"
    figure.text(0.988, 0.008, program, ha="right", va="bottom",
                color="#9aa4ad", fontsize=8)
    if path.endswith(".svg"):
        metadata = {"Title": title, "Description": query, "Creator": program,
                    "Date": None}
    elif path.endswith(".png"):
        metadata = {"Title": title, "Description": query, "Software": program}
    else:
        raise Unfit(f"{path}: a plot is an .svg or a .png")
    figure.savefig(path, metadata=metadata)
    _matplotlib().pyplot.close(figure)


KINDS: dict[str, Callable[..., Any]] = {
    "rrs": rrs, "brdf": brdf, "rose": rose, "height": height}


def _draw(kind: str, data: bytes) -> tuple[Any, str]:
    """The figure, and the question that it answers."""
    if kind == "rows":
        picture = read_exr(data)
        said = {k: v for k, v in picture.attributes.items()
                if isinstance(v, (str, int, float))}
        return rows(picture), json.dumps(said, ensure_ascii=False)
    content = json.loads(data)
    all_series = [Series.from_json(c) for c in content.get("series", [content])]
    return (KINDS[kind](*all_series),
            "; ".join(s.history for s in all_series))


def main(arguments: Sequence[str] | None = None) -> int:
    words = list(sys.argv[1:] if arguments is None else arguments)
    if len(words) != 2 or words[0] not in (*KINDS, "rows"):
        print(f"usage: pelagos-plot {'|'.join(KINDS)}|rows FILE.svg|FILE.png",
              file=sys.stderr)
        return 2
    kind, path = words
    try:
        figure, query = _draw(kind, sys.stdin.buffer.read())
        title = figure.texts[0].get_text()
        save(figure, path, title, query)
    except (MissingPackage, Unfit, OSError, KeyError, ValueError) as e:
        print(f"pelagos-plot: {e}", file=sys.stderr)
        return 3 if isinstance(e, MissingPackage) else 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
