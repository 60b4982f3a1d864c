"""What the plotting scripts' pictures have in common: style, names of quantities, and how they are saved."""

import os

import matplotlib
import numpy as np
from matplotlib.colors import LinearSegmentedColormap, LogNorm
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import nonsingular

matplotlib.use("Agg")  # before pyplot is loaded: a batch node has no display
import matplotlib.pyplot as plt  # noqa: E402

from gentbeam_results import ResultsError  # noqa: E402

FORMATS = ("png", "pdf", "svg")
MILLIMETRES = 1.0 / 25.4
# As a part of what the values of a history span.
ZERO_IS_NEAR = 0.25
# Colours of a map between two numbers on its bar.
LEVELS_BETWEEN = 4
# From a number on a line of a map to the edge, and half of that to the next number, as a part of the panel.
ROOM_OF_A_LABEL = 0.06

# Okabe and Ito's colours, told apart by every kind of colour vision; yellow is too faint for a line.
COLOURS = ("#000000", "#D55E00", "#0072B2", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")
# Lines coloured by a number; the yellow end of viridis is too faint on paper.
LINE_COLOURS = LinearSegmentedColormap.from_list(
    "viridis_dark", matplotlib.colormaps["viridis"](np.linspace(0.0, 0.88, 256))
)
# One dash pattern fewer than colours, so that their pairs repeat late.
DASHES = ("-", (0, (6, 2)), (0, (6, 1.5, 1, 1.5)), (0, (1.2, 1.4)), (0, (10, 2, 3, 2)), (0, (3, 1.2)))

STYLE = {
    "font.family": "STIXGeneral",
    "mathtext.fontset": "stix",
    "font.size": 9,
    "axes.linewidth": 0.6,
    "axes.labelsize": 9,
    "axes.titlesize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.unicode_minus": True,
    "axes.formatter.use_mathtext": True,
    "axes.formatter.limits": (-4, 5),
    "lines.linewidth": 1.0,
    "lines.dash_capstyle": "butt",
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 3,
    "ytick.major.size": 3,
    "savefig.dpi": 300,
    "pdf.fonttype": 42,  # editable text
    "svg.fonttype": "none",
    "svg.hashsalt": "gentbeam",
}

SYMBOLS = {
    "jm": "J_m",
    "e": "E",
    "nu": r"\nu",
    "mu": r"\mu",
    "rho": r"\rho",
    "beta": r"\beta",
    "l": "L",
    "u1": "u_1",
    "u3": "u_3",
    "y1": "y_1",
    "y3": "y_3",
    "xi": r"\xi",
    "v1": r"\dot{u}_1",
    "v3": r"\dot{u}_3",
    "a1": r"\ddot{u}_1",
    "a3": r"\ddot{u}_3",
}
# From here on `jm` means a material without limit of its chains.
UNLIMITED_JM = 1e15


def symbol(name):
    """A quantity's name in mathtext, without the dollars."""
    if name.lower() in SYMBOLS:
        return SYMBOLS[name.lower()]
    return name if len(name) == 1 else r"\mathrm{%s}" % name.replace("_", r"\_")


def escape(words):
    """Words from a file, so that mathtext takes nothing in them for a formula."""
    return words.replace("$", r"\$")


def axis_label(quantity, unit):
    return f"{quantity} ({escape(unit)})" if unit else quantity


def draw_error_bar(axis, history, colour, only_end):
    """The estimated error of a history, where it has one: of its end, or as a band along it."""
    if history.error_bar is None:
        return
    if only_end:
        axis.errorbar(
            history.time[-1:],
            history.values[-1:],
            history.error_bar,
            color=colour,
            capsize=2.5,
            linewidth=0.8,
            clip_on=False,
        )
    else:
        low, high = history.values - history.error_bar, history.values + history.error_bar
        axis.fill_between(history.time, low, high, color=colour, alpha=0.25, linewidth=0.0)


def draw_zero(axis):
    """A line at zero, where that is within or near the range of what is drawn; a constant needs a scale."""
    low, high = axis.dataLim.intervaly
    near = ZERO_IS_NEAR * (high - low)
    is_constant = high - low <= 1e-6 * max(abs(low), abs(high))
    if is_constant or low - near <= 0.0 <= high + near:
        axis.axhline(0.0, color="0.6", linewidth=0.4, zorder=0)


def error_bar_words(histories):
    """What the bars or bands of some histories of one kind mean; nothing where there are none."""
    bars = [history for history in histories if history.error_bar is not None]
    if not bars:
        return ""
    if len(histories) > 1:
        return "bands and bars: estimated errors"
    return escape(f"estimated error: {bars[0].error_bar:.2g} {bars[0].unit}".rstrip())


def draw_levels(figure, axis, x, y, z, label, logarithmic=False, lines=True):
    """A map of z in colours, with a bar and white lines at round numbers."""
    low, high = nonsingular(z.min(), z.max(), expander=0.01, tiny=1e-9)
    marked = round_levels(low, high, logarithmic)
    inward, outward = (np.log, np.exp) if logarithmic else (np.array, np.array)
    steps = np.arange((len(marked) - 1) * LEVELS_BETWEEN + 1) / LEVELS_BETWEEN
    levels = outward(np.interp(steps, np.arange(len(marked)), inward(marked)))
    # The nearest ones outside z are the ends of the bar.
    below, above = np.searchsorted(levels, low, "right") - 1, np.searchsorted(levels, high, "left")
    levels = levels[max(below, 0) : above + 1]
    norm = LogNorm(levels[0], levels[-1]) if logarithmic else None
    shown = axis.contourf(x, y, z, levels=levels, norm=norm, cmap="viridis")
    marked = [level for level in marked if levels[0] <= level <= levels[-1]]
    bar = figure.colorbar(shown, ax=axis, label=label, ticks=marked)
    bar.minorticks_off()
    if logarithmic:
        bar.set_ticks(marked, labels=[logarithmic_label(level) for level in marked])
    if lines:
        drawn = axis.contour(x, y, z, levels=marked, colors="white", linewidths=0.4, linestyles="solid")
        figure.canvas.draw()  # settles where the lines run, for the labels' angles, and what the bar says
        words = [tick.get_text() for tick in bar.ax.get_yticklabels()]
        label_levels(axis, drawn, dict(zip(marked, words)))


def round_levels(low, high, logarithmic):
    """Some six round numbers, the first not above the lowest value, the last not below the highest."""
    if logarithmic:
        decades = np.log10(high / low)
        factors = [1.0, 2.0, 5.0] if decades < 3.0 else [1.0]
        first, last = int(np.floor(np.log10(low))), int(np.ceil(np.log10(high)))
        step = max(1, int(np.ceil(decades / 7.0)))
        levels = [factor * 10.0**power for power in range(first, last + step, step) for factor in factors]
    else:
        levels = MaxNLocator(nbins=6, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high)
    levels = np.array(levels)
    return levels[max(np.searchsorted(levels, low, "right") - 1, 0) : np.searchsorted(levels, high) + 1]


def logarithmic_label(value):
    power = int(np.floor(np.log10(value) + 1e-9))
    if -3 <= power <= 3:
        return f"{value:g}"
    factor = round(value / 10.0**power)
    return rf"$10^{{{power}}}$" if factor == 1 else rf"${factor} \times 10^{{{power}}}$"


def label_levels(axis, lines, words):
    """A number on every line at the place that is farthest from the edges and from the others' numbers;
    none on a line that has no room for it."""
    taken, places = [], []
    to_panel = axis.transData + axis.transAxes.inverted()
    for path in lines.get_paths():
        if not len(path.vertices):
            continue
        points = to_panel.transform(path.vertices)
        room = np.min([points[:, 0], 1.0 - points[:, 0], points[:, 1], 1.0 - points[:, 1]], axis=0)
        for other in taken:
            room = np.minimum(room, 0.5 * np.hypot(*(points - other).T))
        best = int(np.argmax(room))
        if room[best] > ROOM_OF_A_LABEL:
            taken.append(points[best])
            places.append(path.vertices[best])
    axis.clabel(lines, fontsize=6, fmt=words, manual=places)


def add_picture_options(parser, size_help):
    parser.add_argument("-o", "--output", metavar="FILE", help="the picture; its ending chooses the format")
    parser.add_argument("--format", choices=FORMATS, help="the format where -o does not say (default: png)")
    parser.add_argument("--size", nargs=2, type=float, metavar=("W", "H"), help=size_help)
    parser.add_argument("--title", help="a title above the picture (default: none)")
    parser.add_argument("--csv", metavar="FILE", help="also write the numbers drawn (- is standard output)")


def picture_path(args, default_stem):
    """Where the picture goes; an ending that is no picture format is refused before anything is drawn."""
    path = args.output or f"{default_stem}.{args.format or FORMATS[0]}"
    ending = os.path.splitext(path)[1][1:].lower()
    if not ending:
        path = f"{path}.{args.format or FORMATS[0]}"
    elif ending not in FORMATS:
        raise ResultsError(f"{path}: unknown picture format (there are: {', '.join(FORMATS)})")
    elif args.format and args.format != ending:
        raise ResultsError(f"{path}: --format {args.format} contradicts the file's ending")
    if args.size and not all(10.0 <= length <= 2000.0 for length in args.size):
        raise ResultsError("--size: width and height in millimetres, 10 to 2000")
    return path


def save_picture(figure, path):
    """Saves without a date: the same numbers make the same file."""
    undated = {"pdf": {"CreationDate": None}, "svg": {"Date": None}}
    figure.savefig(path, metadata=undated.get(os.path.splitext(path)[1][1:].lower()))
    plt.close(figure)
    print(f"wrote {path}")
