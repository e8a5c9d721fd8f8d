"""Tables, figures and pages for studies/papers.py. Needs numpy and matplotlib (tools/deps papers)."""

import html
import io
import os
import pathlib

import matplotlib
matplotlib.use("svg")
import matplotlib.pyplot as plt

ROOT = pathlib.Path(__file__).resolve().parent.parent
CHASLES = pathlib.Path(os.environ.get("CHASLES_BINARY", ROOT / "build/release/bin/chasles"))
DOCS, STUDY = ROOT / "docs/papers.md", ROOT / "studies/papers.md"
PNG = {"dpi": 110, "metadata": {"Software": None}}  # of savefig
# A constant salt: the same figure is the same text.
plt.rcParams.update({"svg.hashsalt": "chasles", "font.size": 8})


def svg(figure):
    text = io.StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None})
    plt.close(figure)
    return text.getvalue()[text.getvalue().index("<svg"):]


def number(figures, name, digits):
    value = figures.get(name)
    return "-" if value is None else f"{value:.{digits}f}"


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def as_html(markdown):
    lines = [[html.escape(cell.strip()) for cell in line.strip("|").split("|")] for line in markdown.splitlines()]
    head, *rows = [lines[0], *lines[2:]]
    cells = lambda tag, row: "".join(f"<{tag}>{cell}</{tag}>" for cell in row)
    return f"<table><tr>{cells('th', head)}</tr>" + "".join(f"<tr>{cells('td', row)}</tr>" for row in rows) + "</table>"


def page(title, introduction, parts):
    """`parts`: headings, each with a table in Markdown or a list of SVG figures."""
    body = ""
    for heading, part in parts:
        content = as_html(part) if isinstance(part, str) else \
            '<div class="figures">' + "".join(f"<figure>{figure}</figure>" for figure in part) + "</div>"
        body += f"<h2>{heading}</h2>{content}\n"
    return f"""<!doctype html><html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1"><title>{title}</title><style>
body {{ font: 15px/1.5 sans-serif; max-width: 1500px; margin: 2em auto; padding: 0 1em; }}
.figures {{ display: grid; grid-template-columns: repeat(auto-fit, minmax(min(420px, 100%), 1fr)); gap: 8px; }}
figure {{ margin: 0; }} svg {{ width: 100%; height: auto; }}
table {{ border-collapse: collapse; margin: 1em 0; display: block; overflow-x: auto; }}
td, th {{ border: 1px solid #bbb; padding: 3px 9px; text-align: left; }}
</style></head><body><h1>{title}</h1><p>{introduction}</p>
{body}</body></html>
"""
