#!/usr/bin/env python3
"""python3 -m studies.table [NAME...]: runs `chasles run` on all recordings of CHASLES_DATA (../shared/data)
in every variant of the tables. It fills docs/results.md (between its markers) and writes studies/results.md.
With names (substrings of "ece276a_2020/0027") it runs only those recordings, and only prints.
out/table/results.json keeps the unrounded figures."""

import json
import os
import pathlib
import platform
import subprocess
import sys

from studies.pages import fill

ROOT = pathlib.Path(__file__).resolve().parent.parent
CHASLES = pathlib.Path(os.environ.get("CHASLES_BINARY", ROOT / "build/release/bin/chasles"))
DATA = pathlib.Path(os.environ.get("CHASLES_DATA", ROOT / "../shared/data")) / "kitti_tracks"

# The ECE276A archives contain no truth; the .mat files do.
TRUTH = {
    "ece276a_2018/0020": "0020_gt_imu_stars.tum",
    "ece276a_2018/0027": "0027_gt_imu_stars.tum",
    "ece276a_2018/0042": "0042_gt_imu_stars.tum",
    "ece276a_2020/0022": "0022_pseudogt_orbslam3_imu.tum",
    "ece276a_2020/0027": "0027_gt_imu_stars.tum",
}

REPAIRED = ["--set", "reader.stale_pixels=cut", "--set", "reader.extrinsics=auto"]
VARIANTS = {
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


def recordings():
    npz = sorted(DATA.glob("ece276a_*/*.npz"))
    mat = sorted(DATA.glob("stars/*.mat"))
    return {f"{p.parent.name}/{p.stem}": p for p in npz + mat}


def run(name, path, arguments):
    """The figures of one run; a run that ended with an error has only its `error`."""
    command = [str(CHASLES), "run", str(path), "--json", "--quiet", *arguments]
    if name in TRUTH:
        command += ["--truth", str(DATA / "ground_truth" / TRUTH[name])]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    try:
        figures = json.loads(done.stdout)
    except json.JSONDecodeError:
        figures = {}
    if done.returncode != 0:
        figures["error"] = (done.stderr.strip().splitlines() or ["?"])[-1]
        figures["exit_code"] = done.returncode
    figures["command"] = " ".join(["chasles", "run", name, *arguments])
    return figures


def cell(figures, figure, digits):
    value = figures.get(figure)
    if not isinstance(value, (int, float)):
        return "diverged" if figures.get("exit_code") == 4 and figure == "ate_m" else "-"
    if abs(value) >= 1e5:
        return f"{value:.0e}"
    return f"{value:.{0 if abs(value) >= 1000 else digits}f}"


def markdown(header, rows, left=1):
    """A padded table; the first `left` columns hold text, the others numbers."""
    widths = [max(len(r[i]) for r in [header, *rows]) for i in range(len(header))]
    pad = lambda text, i: text.ljust(widths[i]) if i < left else text.rjust(widths[i])
    rule = ["-" * w if i < left else "-" * (w - 1) + ":" for i, w in enumerate(widths)]
    lines = [[pad(text, i) for i, text in enumerate(row)] for row in [header, *rows]]
    lines.insert(1, rule)
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def compact_table(results):
    header = ["recording", "landmarks", "dead reckoning m", "Du's filter m", "Chasles m",
              "100 m: dead reckoning %", "Chasles %", "attitude °", "NEES (6)", "× real time"]
    rows = []
    for name, runs in results.items():
        default, dead = runs[DEFAULT], runs["dead reckoning"]
        du = [runs[v] for v in ("Du, set 1", "Du, set 2")]
        rows.append([
            name.replace("_sync_KLT", ""), cell(default, "landmarks", 0), cell(dead, "ate_m", 2),
            " / ".join(cell(figures, "ate_m", 1) for figures in du),
            cell(default, "ate_m", 2), cell(dead, "rpe_100m_percent", 2),
            cell(default, "rpe_100m_percent", 2), cell(default, "attitude_deg", 2),
            cell(default, "nees_pose", 1), cell(default, "realtime_factor", 0)])
    return markdown(header, rows)


def machine():
    model = next((line.split(":", 1)[1].strip()
                  for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines()
                  if line.startswith("model name")), platform.processor())
    return f"{os.cpu_count()} cores, {model}, {platform.platform(terse=True)}; one thread used"


def full_page(results):
    page = [PROLOGUE, f"Machine: {machine()}.", ""]
    header = ["variant", *[heading for heading, _, _ in FIGURES]]
    for name, runs in results.items():
        page += [f"## {name}", ""]
        rows = [[way, *[cell(figures, key, digits) for _, key, digits in FIGURES]]
                for way, figures in runs.items()]
        page += [markdown(header, rows), ""]
        for way, figures in runs.items():
            if "error" in figures:
                page += [f"{way}: exit code {figures['exit_code']}, {figures['error']}", ""]
    return "\n".join(page)


def main():
    if not DATA.is_dir():
        sys.exit(f"studies/table.py: no recordings in {DATA}; set CHASLES_DATA")
    results = {}
    chosen = sys.argv[1:]
    for name, path in recordings().items():
        if chosen and not any(part in name for part in chosen):
            continue
        results[name] = {}
        for way, arguments in VARIANTS.items():
            if "repaired" in way and path.suffix != ".npz":
                continue  # the reader corrects the archives alone
            print(f"{name}: {way}", file=sys.stderr, flush=True)
            results[name][way] = run(name, path, arguments)
    out = ROOT / "out/table"
    out.mkdir(parents=True, exist_ok=True)
    (out / "results.json").write_text(json.dumps(results, indent=1) + "\n")
    if chosen:
        print(full_page(results))
        return
    table = compact_table(results)
    fill(ROOT / "docs/results.md", "results", table)
    (ROOT / "studies/results.md").write_text(full_page(results))
    print(table)


if __name__ == "__main__":
    main()
