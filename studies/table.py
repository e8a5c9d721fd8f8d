#!/usr/bin/env python3
"""python3 -m studies.table [NAME...]: runs `chasles run` on all recordings of CHASLES_DATA (../shared/data)
in every variant of the tables. It fills docs/results.md (between its markers) and writes studies/results.md.
With names (substrings of "ece276a_2020/0027") it runs only those recordings, and only prints.
out/table/results.json keeps the unrounded figures."""

import json
import os
import pathlib
import platform
import sys

from studies.kitti import KITTI, REPAIRED, recordings, short_name, truth_of
from studies.pages import fill, padded_table
from studies.program import ROOT, Json, chasles, parser

PAGE = ROOT / "docs/results.md"
MARKERS = {PAGE: ("results",)}
VARIANTS: dict[str, list[str]] = {
    "dead reckoning": ["--mode", "localize"],
    "map": ["--mode", "map"],
    "Du, set 1": ["--config", "studies/configs/du-set1.yaml"],
    "Du, set 2": ["--config", "studies/configs/du-set2.yaml"],
    "Du, set 1, repaired data": ["--config", "studies/configs/du-set1.yaml", *REPAIRED],
    "Du, set 2, repaired data": ["--config", "studies/configs/du-set2.yaml", *REPAIRED],
    "standard": ["--chart", "standard"],
    "left-se3": ["--chart", "left-se3"],
    "right-se3": ["--chart", "right-se3"],
    "right-sen3 (default)": [],
}
DEFAULT = "right-sen3 (default)"

# Heading, name in the json, digits.
FIGURES = [
    ("ATE m", "ate_m", 2),
    ("ATE first pose m", "ate_first_pose_m", 2),
    ("attitude °", "attitude_deg", 2),
    ("100 m %", "rpe_100m_percent", 2),
    ("NIS/dof", "nis_per_dof", 2),
    ("NEES", "nees_pose", 1),
    ("landmarks", "landmarks", 0),
    ("frames", "frames", 0),
    ("s", "seconds_wall", 2),
    ("CPU s", "seconds_cpu", 2),
    ("× real time", "realtime_factor", 0),
]


PROLOGUE = """# Stereo-velocity runs: all variants

This page has every figure of every recording, chart and baseline. `make table` writes it: it runs
`chasles run RECORDING` with the options of each row. [docs/results.md](../docs/results.md) explains
the variants and has the conclusions, and [docs/evaluation.md](../docs/evaluation.md) defines the
figures.

- ATE is given after SE(3) alignment and with the first poses aligned.
- NIS is a mean per degree of freedom, and 1 is consistent. NEES is the mean of the pose, and 6 is
  consistent.
"""


def run(name: str, path: pathlib.Path, arguments: list[str]) -> Json:
    """The figures of one run; a run that ended with an error has only its `error`."""
    done = chasles("run", path, "--json", "--quiet", *arguments, *truth_of(name), accepted=None, silent=True)
    try:
        figures: Json = json.loads(done.stdout)
    except json.JSONDecodeError:
        figures = {}
    if done.returncode != 0:
        figures["error"] = (done.stderr.strip().splitlines() or ["?"])[-1]
        figures["exit_code"] = done.returncode
    figures["command"] = " ".join(["chasles", "run", name, *arguments])
    return figures


def cell(figures: Json, figure: str, digits: int) -> str:
    value = figures.get(figure)
    if not isinstance(value, (int, float)):
        return "diverged" if figures.get("exit_code") == 4 and figure == "ate_m" else "-"
    if abs(value) >= 1e5:
        return f"{value:.0e}"
    return f"{value:.{0 if abs(value) >= 1000 else digits}f}"


def compact_table(results: dict[str, dict[str, Json]]) -> str:
    header = ["recording", "landmarks", "dead reckoning m", "Du's filter m", "Chasles m",
              "100 m: dead reckoning %", "Chasles %", "attitude °", "NEES (6)", "× real time"]
    rows = []
    for name, runs in results.items():
        default, dead = runs[DEFAULT], runs["dead reckoning"]
        du = [runs[v] for v in ("Du, set 1", "Du, set 2")]
        rows.append([
            short_name(name), cell(default, "landmarks", 0), cell(dead, "ate_m", 2),
            " / ".join(cell(figures, "ate_m", 1) for figures in du),
            cell(default, "ate_m", 2), cell(dead, "rpe_100m_percent", 2),
            cell(default, "rpe_100m_percent", 2), cell(default, "attitude_deg", 2),
            cell(default, "nees_pose", 1), cell(default, "realtime_factor", 0)])
    return padded_table(header, rows)


def machine() -> str:
    model = next((line.split(":", 1)[1].strip()
                  for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines()
                  if line.startswith("model name")), platform.processor())
    return f"{os.cpu_count()} cores, {model}, {platform.platform(terse=True)}; one thread used"


def full_page(results: dict[str, dict[str, Json]]) -> str:
    page = [PROLOGUE, f"Machine: {machine()}.", ""]
    header = ["variant", *[heading for heading, _, _ in FIGURES]]
    for name, runs in results.items():
        page += [f"## {name}", ""]
        rows = [[way, *[cell(figures, key, digits) for _, key, digits in FIGURES]]
                for way, figures in runs.items()]
        page += [padded_table(header, rows), ""]
        for way, figures in runs.items():
            if "error" in figures:
                page += [f"{way}: exit code {figures['exit_code']}, {figures['error']}", ""]
    return "\n".join(page)


def main() -> None:
    arguments = parser(__doc__)
    arguments.add_argument("names", nargs="*", metavar="NAME")
    chosen = arguments.parse_args().names
    if not KITTI.is_dir():
        sys.exit(f"studies/table.py: no recordings in {KITTI}; set CHASLES_DATA")
    results: dict[str, dict[str, Json]] = {}
    for name, path in recordings().items():
        if chosen and not any(part in name for part in chosen):
            continue
        results[name] = {}
        for way, options in VARIANTS.items():
            if "repaired" in way and path.suffix != ".npz":
                continue  # the reader corrects the archives alone
            print(f"{name}: {way}", file=sys.stderr, flush=True)
            results[name][way] = run(name, path, options)
    out = ROOT / "out/table"
    out.mkdir(parents=True, exist_ok=True)
    (out / "results.json").write_text(json.dumps(results, indent=1) + "\n")
    if chosen:
        print(full_page(results))
        return
    table = compact_table(results)
    fill(PAGE, "results", table)
    (ROOT / "studies/results.md").write_text(full_page(results))
    print(table)


if __name__ == "__main__":
    main()
