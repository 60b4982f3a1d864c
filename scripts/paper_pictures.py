"""The pictures of the report on the paper."""

from matplotlib.ticker import MaxNLocator
from PIL import Image

from gentbeam_pictures import COLOURS, MILLIMETRES, STYLE, UNLIMITED_JM, plt, symbol
from plot_tip import label_lines

WIDTH = 160.0
RESOLUTION = 220
CONTINUUM = {"color": "#000000", "linestyle": (0, (2.2, 1.8)), "linewidth": 0.9, "zorder": 3}
SMALL = 7.5
# From the softest of a family to the stiffest.
SHADES = ("#000000", "#0072B2", "#56B4E9", "#009E73", "#E69F00", "#D55E00")
MARKERS = "osD^v"


def jm_label(jm):
    value = r"\infty" if jm >= UNLIMITED_JM else f"{jm:g}"
    return f"${symbol('jm')} = {value}$"


def shades(family):
    """A colour for every jm; the softest and the stiffest have the same in every family."""
    apart = (len(SHADES) - 1) / (len(family) - 1)
    return {jm: SHADES[round(i * apart)] for i, jm in enumerate(family)}


def save(figure, folder, name):
    """As PDF, and as PNG of few colours, which takes a third of the room; the latter's path."""
    figure.savefig(folder / f"{name}.pdf", metadata={"CreationDate": None})
    path = folder / f"{name}.png"
    figure.savefig(path, dpi=RESOLUTION)
    plt.close(figure)
    with Image.open(path) as picture:
        fewer = picture.convert("RGB").quantize(128)
    fewer.save(path, optimize=True)
    return path


def new_figure(height, *grid, **options):
    return plt.subplots(
        *grid, layout="constrained", figsize=(WIDTH * MILLIMETRES, height * MILLIMETRES), **options
    )


def dress(axis, ylabel):
    axis.set_ylabel(ylabel)
    axis.margins(x=0.0)
    axis.axhline(0.0, color="0.6", linewidth=0.4, zorder=0)
    axis.yaxis.set_major_locator(MaxNLocator(nbins=5))


def time_axis(axis, unit):
    axis.xaxis.set_major_locator(MaxNLocator(nbins=7, steps=[1, 2, 5, 10]))
    axis.set_xlabel(f"Time ({unit})")


def corner(axis, words):
    axis.set_title(words, loc="left", fontsize=plt.rcParams["xtick.labelsize"], pad=3)


def draw_family(folder, name, family, deck, fine, continuum, ylabel, unit):
    """All of a family on top; below it the softest and the stiffest beside the continuum."""
    colours = shades(family)
    with plt.rc_context(STYLE):
        figure, axes = new_figure(150.0, 3, 1, sharex=True, height_ratios=(1.5, 1, 1))
        for jm in family:
            axes[0].plot(deck[jm].time, deck[jm].values, color=colours[jm])
        dress(axes[0], ylabel)
        end = deck[family[0]].time[-1]
        for axis, jm in zip(axes[1:], (family[0], family[-1])):
            ours, theirs = fine[jm].until(end), continuum[jm].until(end)
            axis.plot(
                ours.time, ours.values, color=SHADES[-1], linewidth=1.4, label="gentbeam, fine mesh and step"
            )
            axis.plot(theirs.time, theirs.values, label="2D continuum", **CONTINUUM)
            dress(axis, ylabel)
            corner(axis, jm_label(jm))
        axes[0].set_xlim(0.0, end)
        corner(axes[0], "gentbeam, the deck's mesh and step")
        axes[1].legend(
            frameon=False, fontsize=SMALL, ncols=2, loc="lower right", bbox_to_anchor=(1.0, 0.97), borderpad=0
        )
        time_axis(axes[-1], unit)
        figure.align_ylabels(axes)
        label_lines(figure, axes[0], [(jm_label(jm), deck[jm], colours[jm]) for jm in family])
        return save(figure, folder, name)


def draw_validation(folder, name, deck, small, continuum, published, ylabel, unit):
    """Example 1 without limit of the chains, beside what others computed."""
    with plt.rc_context(STYLE):
        figure, axis = new_figure(85.0)
        end = deck.time[-1]
        axis.plot(small.time, small.values, color="0.6", label="gentbeam, small displacements")
        axis.plot(deck.time, deck.values, color="#D55E00", linewidth=1.6, label="gentbeam, 10 elements")
        axis.plot(continuum.time, continuum.values, label="2D continuum", **CONTINUUM)
        times, values = zip(*published)
        axis.plot(
            times,
            values,
            linestyle="",
            marker="o",
            markersize=5.5,
            markerfacecolor="white",
            markeredgecolor="#0072B2",
            zorder=4,
            label="linear-resultant beam, extremes",
        )
        dress(axis, ylabel)
        axis.set_xlim(0.0, end)
        time_axis(axis, unit)
        figure.legend(frameon=False, ncols=2, loc="outside upper center", fontsize=8)
        return save(figure, folder, name)


def draw_mesh(folder, name, meshes, panels, family):
    """Values by the number of elements, one panel a source; `panels` is (title, {jm: values})."""
    colours = shades(family)
    with plt.rc_context(STYLE):
        figure, axes = new_figure(75.0, 1, len(panels), sharey=True)
        for axis, (title, table) in zip(axes, panels):
            for jm, marker in zip(family, MARKERS):
                axis.plot(
                    meshes,
                    table[jm],
                    color=colours[jm],
                    marker=marker,
                    markersize=3.5,
                    label=jm_label(jm),
                    clip_on=False,
                )
            corner(axis, title)
            axis.axhline(1.0, color="0.6", linewidth=0.4, zorder=0)
            axis.set_xticks(meshes[::2])
            axis.set_xlabel("Elements")
        axes[0].set_ylabel("Relative to 28 elements")
        lines = axes[0].get_legend_handles_labels()
        figure.legend(*lines, frameon=False, ncols=5, loc="outside lower center")
        return save(figure, folder, name)


def draw_stiffening(folder, name, panels):
    """How much smaller than without limit the largest deflection is, by jm; one panel an example."""
    with plt.rc_context(STYLE):
        figure, axes = new_figure(80.0, 1, len(panels), sharey=True)
        for axis, (title, law, beam, continuum, claim) in zip(axes, panels):
            axis.plot(*law, color="0.6", label="small static loads: $1-E/E_\\mathrm{eff}$")
            axis.plot(
                *beam, color=COLOURS[1], marker="o", markersize=4, linestyle="", label="gentbeam, largest"
            )
            axis.plot(
                *continuum,
                color="#000000",
                marker="x",
                markersize=6,
                linestyle="",
                label="2D continuum, largest",
            )
            axis.plot(*claim, color=COLOURS[2], marker="*", markersize=9, linestyle="", label="the paper")
            axis.set_xscale("log")
            axis.set_xticks([0.5, 1, 2, 5, 10], ["0.5", "1", "2", "5", "10"])
            axis.minorticks_off()
            axis.set_xlabel(f"${symbol('jm')}$")
            axis.set_ylim(0.0, 32.0)
            corner(axis, title)
        axes[0].set_ylabel("Smaller by (%)")
        lines = axes[0].get_legend_handles_labels()
        figure.legend(*lines, frameon=False, ncols=4, loc="outside upper center")
        return save(figure, folder, name)
