#!/usr/bin/env python3
"""python3 -m studies.study [RUNS]: the Monte Carlo study of studies/consistency.md. It runs the scenes hallway
and turntable, 100 times (or RUNS) each. The filters are Kleinert & Stilla's, the default in every
chart, and one with early landmark initialisation (studies/configs/early.yaml), all on the same noise. It
fills the page between its markers. out/study keeps the studies, and an interrupted one resumes."""

import os
import pathlib
import subprocess
import sys

from studies.pages import fill

ROOT = pathlib.Path(__file__).resolve().parent.parent
CHASLES = pathlib.Path(os.environ.get("CHASLES_BINARY", ROOT / "build/release/bin/chasles"))
PAGE = ROOT / "studies/consistency.md"
CHARTS = ["--charts", "standard,left-se3,right-se3,right-sen3", "--landmarks", "inverse-depth"]
# Settings of --set are those of all filters of a command, so the assumed depth has a command of its own.
FILTERS = {
    "default": ["--preset", "paper,default", "--config", ROOT / "studies/configs/early.yaml", *CHARTS, "--init", "multi-view"],
    "fixed-depth": [*CHARTS, "--init", "fixed-depth", "--set", "inverse_depth=0.3", "--set", "inverse_depth_sigma=0.3"],
}


def tables(scene, runs, name):
    """The two tables of a study, each with its title: rows of cells."""
    folder = ROOT / "out/study" / f"{scene}-{name}-{runs}"
    folder.parent.mkdir(parents=True, exist_ok=True)
    command = [CHASLES, "montecarlo", scene, "--runs", str(runs), *FILTERS[name], "--markdown", "--resume", "-o", folder]
    text = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout.strip()
    found = []
    for line in text.splitlines():
        if line.startswith("### "):
            found.append((line, []))
        elif line.startswith("|"):
            found[-1][1].append([cell.strip() for cell in line.strip("|").split("|")])
    return found


def padded(rows):
    """The rows as a table with columns of equal width; the first holds text, the others numbers."""
    widths = [max(len(row[i]) for row in rows if not set(row[i]) <= set("-:")) for i in range(len(rows[0]))]
    lines = []
    for row in rows:
        if set(row[0]) <= set("-:"):
            row = ["-" * widths[0], *["-" * (w - 1) + ":" for w in widths[1:]]]
        lines.append([row[0].ljust(widths[0]), *[cell.rjust(w) for cell, w in zip(row[1:], widths[1:])]])
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def study(scene, runs):
    pairs = zip(tables(scene, runs, "default"), tables(scene, runs, "fixed-depth"))
    return "\n\n".join(f"{title}\n\n{padded(rows + more[2:])}" for (title, rows), (_, more) in pairs)


def main():
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    for scene in ("hallway", "turntable"):
        fill(PAGE, scene, study(scene, runs))


main()
