"""A report of headings, paragraphs, tables and pictures, written as one HTML page and as Markdown.

Texts are inline HTML (<i>, <sub>, <b>, <code>, entities), which both formats understand.
"""

import base64
import html
import re
from pathlib import Path

CSS = """
:root { color-scheme: light; }
body { font: 17px/1.55 Georgia, "Times New Roman", serif; color: #1b1b1b; background: #fff;
       max-width: 48rem; margin: 2.5rem auto 5rem; padding: 0 1.2rem; }
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 .4rem; }
h2 { font-size: 1.4rem; margin: 3rem 0 .6rem; padding-top: .6rem; border-top: 1px solid #bbb; }
h3 { font-size: 1.1rem; margin: 2rem 0 .4rem; }
nav { font-size: .92rem; columns: 2; margin: 1.2rem 0; }
nav a { display: block; break-inside: avoid; }
a { color: #00538a; text-decoration: none; }
a:hover { text-decoration: underline; }
.wide { overflow-x: auto; margin: 1.2rem 0; }
table { border-collapse: collapse; font-size: .88rem; line-height: 1.35; width: 100%;
        border-bottom: 1.5px solid #222; font-variant-numeric: tabular-nums; }
thead th { border-top: 1.5px solid #222; }
th { font-weight: 600; text-align: left; border-bottom: 1px solid #222; vertical-align: bottom; }
th, td { padding: .28rem .55rem; }
td { vertical-align: top; }
th:first-child, td:first-child { padding-left: .1rem; }
td.number, th.number { text-align: right; }
td.number { white-space: nowrap; }
caption, figcaption { font-size: .88rem; line-height: 1.45; color: #444; text-align: left; }
caption { padding-bottom: .4rem; }
figure { margin: 1.4rem 0; }
figure img { width: 100%; height: auto; display: block; }
figcaption { margin-top: .4rem; }
code { font: .84em "DejaVu Sans Mono", Menlo, Consolas, monospace; }
footer { margin-top: 3rem; font-size: .85rem; color: #555; border-top: 1px solid #bbb; padding-top: .6rem; }
@media print { body { font-size: 10.5pt; max-width: none; } figure, table { break-inside: avoid; } }
"""


class Page:
    def __init__(self, title):
        self.title = title
        self.blocks = []

    def heading(self, level, text):
        self.blocks.append(("heading", level, text))

    def paragraph(self, text):
        self.blocks.append(("paragraph", one_line(text)))

    def table(self, header, rows, caption):
        rows = [[str(cell) for cell in row] for row in rows]
        self.blocks.append(("table", header, rows, one_line(caption)))

    def figure(self, picture, caption):
        """`picture` is the path of a PNG file."""
        self.blocks.append(("figure", Path(picture), one_line(caption)))

    def html(self, footer):
        body = [f"<h1>{self.title}</h1>"]
        sections = [block[2] for block in self.blocks if block[0] == "heading" and block[1] == 2]
        links = "\n".join(f'<a href="#{anchor(text)}">{text}</a>' for text in sections)
        kinds = [block[0] for block in self.blocks]
        start = kinds.index("heading") if "heading" in kinds else len(kinds)
        body += [html_block(block) for block in self.blocks[:start]]
        body.append(f"<nav>\n{links}\n</nav>")
        body += [html_block(block) for block in self.blocks[start:]]
        return (
            '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
            '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
            f"<title>{plain(self.title)}</title>\n<style>{CSS}</style>\n</head>\n<body>\n"
            + "\n".join(body)
            + f"\n<footer>{footer}</footer>\n</body>\n</html>\n"
        )

    def markdown(self, pictures):
        """As Markdown whose pictures lie in the folder `pictures`."""
        parts = [f"# {self.title}"]
        for kind, *content in self.blocks:
            if kind == "heading":
                level, text = content
                parts.append(f"{'#' * level} {text}")
            elif kind == "paragraph":
                parts.append(content[0])
            elif kind == "table":
                header, rows, caption = content
                parts += [caption, markdown_table(header, rows)]
            else:
                picture, caption = content
                parts += [f"![{plain(first_sentence(caption))}]({pictures}/{picture.name})", caption]
        return "\n\n".join(parts) + "\n"


def html_block(block):
    kind, *content = block
    if kind == "heading":
        level, text = content
        return f'<h{level} id="{anchor(text)}">{text}</h{level}>'
    if kind == "paragraph":
        return f"<p>{content[0]}</p>"
    return html_table(*content) if kind == "table" else html_figure(*content)


def html_table(header, rows, caption):
    numeric = numeric_columns(header, rows)

    def line(tag, cells):
        marks = (' class="number"' if number else "" for number in numeric)
        return "<tr>" + "".join(f"<{tag}{m}>{c}</{tag}>" for m, c in zip(marks, cells)) + "</tr>"

    body = "\n".join(line("td", row) for row in rows)
    return (
        f'<div class="wide"><table>\n<caption>{caption}</caption>\n<thead>{line("th", header)}</thead>\n'
        f"<tbody>\n{body}\n</tbody>\n</table></div>"
    )


def html_figure(picture, caption):
    data = base64.b64encode(picture.read_bytes()).decode("ascii")
    alternative = html.escape(plain(first_sentence(caption)))
    return (
        f'<figure><img alt="{alternative}" src="data:image/png;base64,{data}">\n'
        f"<figcaption>{caption}</figcaption></figure>"
    )


def markdown_table(header, rows):
    rule = ["--:" if number else "---" for number in numeric_columns(header, rows)]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in (header, rule, *rows))


def numeric_columns(header, rows):
    """Which columns hold numbers (with signs and per cent, or dashes) and no words."""
    return [
        all(re.fullmatch(r"[-−+.\de\s%–∞]*", plain(row[column])) for row in rows)
        for column in range(len(header))
    ]


def one_line(text):
    return " ".join(text.split())


def first_sentence(text):
    return re.split(r"(?<=\.)\s", text, maxsplit=1)[0]


def plain(text):
    """Without tags and entities."""
    return html.unescape(re.sub(r"<[^>]*>", "", text))


def anchor(text):
    return re.sub(r"[^a-z0-9]+", "-", plain(text).lower()).strip("-")
