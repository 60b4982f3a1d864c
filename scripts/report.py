#!/usr/bin/env python3
"""Writes one self-contained HTML page about a gentbeam results file: what was computed, and how it went.

    report.py cantilever.h5                cantilever.html
    report.py cantilever.h5 -o page.html

The page needs nothing beside it: pictures are inside, no script, no font, nothing from a network.
"""

import argparse
import base64
import html
import io
import os
import re

import numpy as np

import report_pictures as pictures
from gentbeam_pictures import STYLE, axis_label, plt
from gentbeam_results import FIELDS, HISTORY_KINDS, Parser, ResultsError, open_results, run_script

STYLES = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1b1f24; background: #fff; max-width: 60rem;
  margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; margin-bottom: .2rem; }
h2 { font-size: 1.25rem; border-bottom: 1px solid #d0d7de; padding-bottom: .2rem; margin-top: 2.2rem; }
h3 { font-size: 1.02rem; margin: 1.4rem 0 .3rem; }
table { border-collapse: collapse; margin: .6rem 0; }
th, td { text-align: left; padding: .15rem .9rem .15rem 0; vertical-align: top; }
th { font-weight: 600; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
img { width: 100%; max-width: 54rem; height: auto; display: block; }
pre { background: #f6f8fa; border: 1px solid #d0d7de; border-radius: 4px; padding: .8rem; overflow-x: auto;
  font-size: 13px; }
.status { display: inline-block; border-radius: 1rem; padding: .05rem .7rem; font-size: .85rem;
  font-weight: 600; }
.complete { background: #dafbe1; color: #116329; }
.other { background: #ffebe9; color: #a40e26; }
nav a { margin-right: 1rem; }
footer { color: #57606a; margin: 3rem 0 1rem; font-size: .85rem; }
@media print { body { max-width: none; } h2 { break-after: avoid; } img { break-inside: avoid; } }
"""
MOST_PROBES = 12


def main():
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", metavar="FILE.h5", help="a results file")
    parser.add_argument("-o", "--output", metavar="FILE.html", help="the page (default: beside the file)")
    args = parser.parse_args()
    path = args.output or os.path.splitext(args.file)[0] + ".html"
    with open_results(args.file) as results, plt.rc_context({**STYLE, "svg.fonttype": "path"}):
        results.refuse_study()
        page = Page(results).html()
    with open(path, "w", encoding="utf-8") as stream:
        stream.write(page)
    print(f"wrote {path}")


def picture(figure, words):
    """A figure as an image inside the page; `words` are for who cannot see it."""
    stream = io.BytesIO()
    figure.savefig(stream, format="svg", metadata={"Date": None}, dpi=200)
    plt.close(figure)
    data = base64.b64encode(stream.getvalue()).decode("ascii")
    return f'<img alt="{html.escape(words, quote=True)}" src="data:image/svg+xml;base64,{data}">'


def table(rows, header=None, numbers_from=None):
    """Rows of texts; the columns from `numbers_from` on are numbers."""

    def cell(text, column):
        kind = ' class="number"' if numbers_from is not None and column >= numbers_from else ""
        return f"<td{kind}>{html.escape(str(text))}</td>"

    lines = ["<table>"]
    if header:
        lines.append("<tr>" + "".join(f"<th>{html.escape(name)}</th>" for name in header) + "</tr>")
    for row in rows:
        lines.append("<tr>" + "".join(cell(text, column) for column, text in enumerate(row)) + "</tr>")
    return "\n".join([*lines, "</table>"])


def finding(rung):
    """What a trial of `auto` changed, and against which other one."""
    if rung["failed"]:
        return "failed", rung["source"]
    if not rung["compared_with"]:
        return "", rung["source"]
    return f"{rung['change']:.3g}", f"{rung['source']}, from {rung['compared_with']}"


def heading(group):
    """Name, kind and scheme of a command, each once."""
    kind = "" if group.name == group.kind else group.kind
    words = ", ".join(word for word in (kind, group.scheme) if word)
    return f"{group.name}: {words}" if words else group.name


class Page:
    def __init__(self, results):
        self.results = results
        self.mesh = results.mesh()
        self.tuned = results.tuning()
        self.scene = pictures.read_scene(results.deck_attribute("scene"))

    def html(self):
        title = self.results.attribute("title") or self.results.name
        groups = self.results.groups
        if not groups:
            raise ResultsError(f"{self.results.path}: holds no solution")
        body = [self.head(title), self.navigation(groups), self.model()]
        if self.tuned:
            body.append(self.tuning())
        body += [self.solution(group) for group in groups]
        body += [
            '<h2 id="deck">Deck</h2>',
            f"<pre>{html.escape(self.results.deck)}</pre>",
            f"<footer>Made by report.py of gentbeam from {html.escape(self.results.name)}.h5.</footer>",
        ]
        return (
            f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
            f'<meta name="viewport" content="width=device-width, initial-scale=1">\n'
            f"<title>{html.escape(title)}</title>\n<style>{STYLES}</style>\n</head>\n<body>\n"
            + "\n".join(body)
            + "\n</body>\n</html>\n"
        )

    def head(self, title):
        results = self.results
        kind = "complete" if results.status == "complete" else "other"
        lines = [f"<h1>{html.escape(title)}</h1>"]
        lines.append(f'<p><span class="status {kind}">{html.escape(results.status)}</span>')
        lines.append(f" {html.escape(results.message)}</p>" if results.message.strip() else "</p>")
        facts = [
            ("computed", results.attribute("created")),
            ("by", f"gentbeam {results.attribute('program_version')} ({results.attribute('git_revision')})"),
            ("in", f"{results.number('wall_seconds'):.3g} s ({results.number('cpu_seconds'):.3g} s CPU)"),
            (
                "parameters",
                ", ".join(f"{name} = {value}" for name, value in results.parameters.items()) or "none",
            ),
        ]
        return "\n".join([*lines, table(facts)])

    def navigation(self, groups):
        names = [("model", "Model")]
        if self.tuned:
            names.append(("tuning", "Choice"))
        names += [(pictures.plain(group.name), group.name) for group in groups]
        links = [f'<a href="#{place}">{html.escape(name)}</a>' for place, name in [*names, ("deck", "Deck")]]
        return "<nav>" + "".join(links) + "</nav>"

    def model(self):
        mesh = self.mesh
        facts = [
            ("length", f"{np.ptp(mesh.x):g} {mesh.unit}"),
            (
                "mesh",
                f"{len(mesh.elements)} elements, {len(mesh.x)} nodes, {int(mesh.fixed.sum())} fields held",
            ),
        ]
        if mesh.thickness is not None:
            heights = sorted({f"{height:g}" for height in mesh.thickness})
            facts.append(("thickness", f"{', '.join(heights)} {mesh.unit}"))
        facts += [("load", load.words) for load in self.scene]
        sketch = picture(pictures.scene(mesh, self.scene), "the beam at rest with its supports and loads")
        return "\n".join(['<h2 id="model">Model</h2>', sketch, table(facts)])

    def tuning(self):
        tuned = self.tuned
        facts = [
            ("chosen", tuned.choice),
            ("asked for", f"{tuned.accuracy:.2g}"),
            ("estimated error", f"{tuned.estimate:.2g}"),
            *((f"of the {name}", f"{value:.2g}") for name, value in tuned.parts.items()),
        ]
        names = ("elements", "nodes", "points", "steps")
        inertias = {1: "diagonal", 2: "translational", 3: "full"}
        rows = [
            (number, *(rung[name] for name in names), inertias.get(rung["inertia"], ""), *finding(rung))
            for number, rung in enumerate(tuned.rungs, start=1)
        ]
        return "\n".join(
            [
                '<h2 id="tuning">Choice of the model</h2>',
                table(facts),
                picture(pictures.tuning(tuned), "parts of the estimated error, and changes between trials"),
                table(rows, ("trial", *names, "inertia", "change", "source")),
            ]
        )

    def solution(self, group):
        lines = [f'<h2 id="{pictures.plain(group.name)}">{html.escape(heading(group))}</h2>']
        if group.kind == "modal":
            return "\n".join(lines + self.modal(group))
        progress = axis_label(group.progress_name, group.progress_unit)
        return "\n".join(
            lines
            + self.probes(group, progress)
            + self.shapes(group, progress)
            + self.resultants(group)
            + self.energies(group, progress)
            + self.solver(group, progress)
        )

    def modal(self, group):
        frequency, modes = group.array("frequency"), group.array("modes")
        unit = group.unit("frequency")
        rows = [(i + 1, f"{value:.7g}", f"{2.0 * np.pi * value:.7g}") for i, value in enumerate(frequency)]
        state, said = self.state_before(group), []
        if state is None:
            state = np.zeros((len(self.mesh.x), len(FIELDS)))
            said = ["<p>The file does not hold the shape of the beam here: drawn on the straight beam.</p>"]
        figure = pictures.modes(self.mesh, state, frequency, modes, unit)
        drawn = picture(figure, "the first modes, on the beam as it is")
        return [drawn, *said, table(rows, ("mode", axis_label("frequency", unit), "angular"), 1)]

    def state_before(self, group):
        """The fields that the commands before this one have left; None where the file does not hold them."""
        before = [
            one for one in self.results.groups if one.order < group.order and one.kind in HISTORY_KINDS
        ]
        if before:
            return before[-1].displacements()[1][-1] if before[-1].has("u") else None
        if re.search(r"^\s*INITIAL\s+displacement", self.results.deck, re.IGNORECASE | re.MULTILINE):
            return None
        return np.zeros((len(self.mesh.x), len(FIELDS)))

    def probes(self, group, progress):
        names = group.probes[:MOST_PROBES]
        if not names:
            return []
        histories = {name: group.history(name) for name in names}
        rows = []
        for name, history in histories.items():
            high, low = int(np.argmax(history.values)), int(np.argmin(history.values))
            rows.append(
                (
                    axis_label(name, history.unit),
                    f"{history.values[high]:.6g}",
                    f"{history.time[high]:.5g}",
                    f"{history.values[low]:.6g}",
                    f"{history.time[low]:.5g}",
                    f"{history.values[-1]:.6g}",
                    "" if history.error_bar is None else f"{history.error_bar:.2g}",
                )
            )
        header = ("probe", "largest", "at", "smallest", "at", "last", "error bar")
        if all(history.error_bar is None for history in histories.values()):
            header, rows = header[:-1], [row[:-1] for row in rows]
        drawn = picture(
            pictures.probes(histories, progress, group.kind == "static"), "histories of the probes"
        )
        left_out = len(group.probes) - len(names)
        note = [f"<p>{left_out} more probes are in the file.</p>"] if left_out else []
        return ["<h3>Probes</h3>", drawn, table(rows, header, 1), *note]

    def shapes(self, group, progress):
        if not group.has("u") or self.mesh.thickness is None:
            return []
        times, fields = group.displacements()
        drawn = pictures.shapes(self.mesh, times, fields, progress, self.results.path)
        return [
            "<h3>Deformed shapes</h3>",
            picture(drawn, "the deformed beam at some instants, and by strain"),
        ]

    def resultants(self, group):
        if not group.has("stress/moment"):
            return []
        names = ("axial", "shear", "moment")
        parts = {name: group.array(f"stress/{name}") for name in names}
        row = int(np.argmax(np.abs(parts["moment"]).max(axis=1)))
        x = self.results.array("mesh/stations/x")
        drawn = pictures.resultants(
            x,
            {name: values[row] for name, values in parts.items()},
            [group.unit(f"stress/{name}") for name in names],
            self.mesh.unit,
            group.array("time")[row],
        )
        return [
            "<h3>Forces and moment at the largest moment</h3>",
            picture(drawn, "resultants along the beam"),
        ]

    def energies(self, group, progress):
        if group.kind != "transient" or not group.has("energy/balance"):
            return []
        ledger = {name: group.array(f"energy/{name}") for name in (*pictures.ENERGIES, "balance")}
        time, unit = group.array("probes/time"), group.unit("energy/strain")
        rows = min(len(time), *map(len, ledger.values()))
        ledger = {name: values[:rows] for name, values in ledger.items()}
        largest = max(np.abs(ledger[name]).max() for name in ("kinetic", "strain", "external"))
        drift = np.abs(ledger["balance"]).max()
        drawn = picture(
            pictures.energies(time[:rows], ledger, unit, progress),
            "energies, and what they fail to add up to",
        )
        part = f" ({100.0 * drift / largest:.3g} % of the largest energy)" if largest > 0.0 else ""
        said = f"<p>Largest error of the balance: {drift:.4g} {html.escape(unit)}{part}.</p>"
        return ["<h3>Energy ledger</h3>", drawn, said]

    def solver(self, group, progress):
        if not group.has("solver/iterations"):
            return []
        record = {name: group.array(f"solver/{name}") for name in ("iterations", "cuts", "step", "residual")}
        steps = min(map(len, record.values()))
        record = {name: values[:steps] for name, values in record.items()}
        if steps < 2:
            return []
        drawn = picture(pictures.solver(record, group.progress_unit), "iterations, step sizes and residuals")
        said = (
            f"<p>{steps - 1} steps, {int(record['iterations'].sum())} Newton iterations "
            f"({record['iterations'][1:].mean():.3g} a step), {int(record['cuts'].sum())} cuts.</p>"
        )
        return ["<h3>Solver</h3>", drawn, said]


if __name__ == "__main__":
    run_script(main)
