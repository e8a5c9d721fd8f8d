#!/usr/bin/env python3
"""python3 -m studies.convergence [SEEDS [RUNS]]: the tables of studies/convergence.md on the error charts in batch
estimation. It runs searches from SEEDS (default 10) perturbed initial estimates of each size on four
recordings. It also runs RUNS (default 100) runs of two short scenes with filter and batch; with 0
that table is not changed. The script fills the page between its markers, processor time included.
out/convergence keeps finished searches, and an interrupted script resumes. Remove it to start again."""

import json
import math
import os
import pathlib
import subprocess
import sys

from studies.pages import fill

ROOT = pathlib.Path(__file__).resolve().parent.parent
CHASLES = pathlib.Path(os.environ.get("CHASLES_BINARY", ROOT / "build/release/bin/chasles"))
DATA = pathlib.Path(os.environ.get("CHASLES_DATA", ROOT / "../shared/data"))
OUT = ROOT / "out/convergence"
PAGE = ROOT / "studies/convergence.md"
CHARTS = ["standard", "left-se3", "right-se3", "right-sen3"]
SHORT = {
    "turntable": ["revolutions=0.3"],
    "hallway": ["hall_length=12", "hall_width=8", "sections=1"],
}
# Least squares without outliers, the robust loss with them. A gate would select pixels during the search.
EXACT = ["--begin", "truth", "--set", "batch.loss=none", "--set", "batch.gate=0"]
SCENES = {
    "turntable": (OUT / "turntable", EXACT),
    "hallway": (OUT / "hallway", EXACT),
    "drive": (DATA / "kitti_tracks/stars/2011_09_26_drive_0035_sync_KLT.mat",
              ["--set", "batch.gate=0", "--set", "velocity_axes=imu", "--set", "velocity_sigma=0.03",
               "--set", "batch.loss_width=2.5"]),
    "AprilGrid": (DATA / "euroc/imu_april", ["--config", ROOT / "studies/configs/euroc.yaml", "--begin", "truth", "--stop", "15",
                                              "--set", "batch.frames_per_keyframe=3", "--set", "batch.gate=0"]),
}
SIZES = [0.1, 0.2, 0.3, 0.5]
SAME_MINIMUM = 1e-4  # relative to the cost


def chasles(*arguments):
    command = [str(a) for a in (CHASLES, *arguments)]
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, cwd=ROOT).stdout


def simulated():
    for scene, settings in SHORT.items():
        if not (OUT / scene).exists():
            chasles("simulate", scene, "-o", OUT / scene, "--quiet", *[a for s in settings for a in ("--set", s)])


class Searches:
    """All searches, each done once and kept in a file."""

    def __init__(self):
        self.file = OUT / "searches.jsonl"
        lines = self.file.read_text().splitlines() if self.file.exists() else []
        self.done = {tuple(s["key"]): s for s in map(json.loads, lines)}

    def search(self, scene, chart, size, seed):
        key = (scene, chart, size, seed)
        if key not in self.done:
            recording, arguments = SCENES[scene]
            command = [str(a) for a in (CHASLES, "run", recording, "--estimator", "batch", *arguments, "--set", "batch.max_iterations=50", "--set", f"batch.chart={chart}",
                                        "--set", f"batch.initial_error={size}", "--set", f"batch.seed={seed}", "--json", "--quiet")]
            run = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT)
            self.done[key] = found = {"key": key, "exit_code": run.returncode}
            if run.returncode == 0:
                s = json.loads(run.stdout)
                found |= {"cost": s["batch"]["final_cost"], "initial_cost": s["batch"]["initial_cost"],
                          "iterations": s["batch"]["iterations"], "ended": s["batch"]["converged"],
                          "stalled": s["batch"]["stalled"], "seconds": s["batch_seconds_solve"],
                          "ate": s["ate_m"], "cpu": s["seconds_cpu"]}
            with self.file.open("a") as stream:
                stream.write(json.dumps(found) + "\n")
            print(f"{scene}, {chart}, {size}, seed {seed}: {found.get('cost', '-')}", file=sys.stderr, flush=True)
        return self.done[key]


def wilson(k, n, z=1.96):
    """The 95 % interval of a proportion (Wilson, 1927)."""
    p, c = k / n, 1 + z * z / n
    half = z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n)) / c
    middle = (p + z * z / (2 * n)) / c
    return max(0, middle - half), min(1, middle + half)


def sign_flips(differences):
    """Exact two-sided p value of the sum of `differences`, of independent pairs, if both signs of each are equally likely."""
    chance = {0: 1.0}
    for d in differences:
        flipped = {}
        for total, p in chance.items():
            for signed in (d, -d):
                flipped[total + signed] = flipped.get(total + signed, 0) + p / 2
        chance = flipped
    return min(1, sum(p for total, p in chance.items() if abs(total) >= abs(sum(differences))))


def mean_and_error(values):
    n = len(values)
    if n < 2:
        return (values[0] if values else math.nan), math.nan
    mean = sum(values) / n
    return mean, math.sqrt(sum((v - mean) ** 2 for v in values) / (n - 1) / n)


def pair(values, digits):
    mean, error = mean_and_error(values)
    return f"{mean:+.{digits}f} ± {error:.{digits}f}"


def proportion(k, n):
    low, high = wilson(k, n)
    return f"{k}/{n} ({100 * low:.0f} to {100 * high:.0f} %)"


def table(header, rows):
    rule = ["---"] + ["---:"] * (len(header) - 1)
    return "\n".join("| " + " | ".join(r) + " |" for r in [header, rule, *rows])


def basin(seeds):
    searches = Searches()
    rows, used, of_chart = [], [], {c: {"found": 0, "all": 0, "alone": 0, "standard_alone": 0, "by_seed": [], "iterations": [], "log_seconds": []} for c in CHARTS}
    for scene in SCENES:
        near = {c: searches.search(scene, c, 0, 0) for c in CHARTS}
        all_of = {(c, size, seed): searches.search(scene, c, size, seed)
                  for size in SIZES for seed in range(1, seeds + 1) for c in CHARTS}
        here = [*near.values(), *all_of.values()]
        used += here
        costs = [s["cost"] for s in here if "cost" in s]
        minimum = min(costs)
        spread = max(s["cost"] for s in near.values()) / minimum - 1
        found = lambda s: s.get("cost", math.inf) <= (1 + SAME_MINIMUM) * minimum
        ates = [s["ate"] for s in here if found(s)]
        rows.append([scene, "filter's estimate", "-", *[("" if found(near[c]) else "not found, ") + f"{near[c]['iterations']}" for c in CHARTS],
                     f"{min(ates):.4f} to {max(ates):.4f}", f"{spread:.0e}"])
        for size in SIZES:
            cells = []
            for c in CHARTS:
                here = [all_of[c, size, seed] for seed in range(1, seeds + 1)]
                good = [s for s in here if found(s)]
                steps = f", {mean_and_error([s['iterations'] for s in good])[0]:.1f}" if good else ""
                cells.append(f"{len(good)}/{len(here)}{steps}")
                of_chart[c]["found"] += len(good)
                of_chart[c]["all"] += len(here)
            first = [s["initial_cost"] for (c, z, _), s in all_of.items() if z == size and "initial_cost" in s]
            ratio = f"{sorted(first)[len(first) // 2] / minimum:.2g}" if first else "-"
            rows.append([scene, f"{size:g}", ratio, *cells, "", ""])
            for seed in range(1, seeds + 1):
                here = {c: all_of[c, size, seed] for c in CHARTS}
                for c in CHARTS:
                    of_chart[c]["alone"] += found(here[c]) and not found(here["standard"])
                    of_chart[c]["standard_alone"] += found(here["standard"]) and not found(here[c])
                if not all(found(s) for s in here.values()):
                    continue
                for c in CHARTS:
                    of_chart[c]["iterations"].append(here[c]["iterations"] - here["standard"]["iterations"])
                    of_chart[c]["log_seconds"].append(math.log(here[c]["seconds"] / here["standard"]["seconds"]))
        # The sizes of a seed are multiples of the same errors, so they are not independent pairs.
        for seed in range(1, seeds + 1):
            count = {c: sum(found(all_of[c, size, seed]) for size in SIZES) for c in CHARTS}
            for c in CHARTS:
                of_chart[c]["by_seed"].append(count[c] - count["standard"])
    text = table(["recording", "size s", "initial cost / minimum", *[f"`{c}`" for c in CHARTS], "ATE [m]", "relative spread of the cost"], rows)
    summary = []
    for c in CHARTS:
        o = of_chart[c]
        paired = c != "standard"
        time, error = mean_and_error(o["log_seconds"])
        summary.append([f"`{c}`", proportion(o["found"], o["all"]),
                        f"{o['alone']}, {o['standard_alone']}" if paired else "-",
                        f"{sign_flips(o['by_seed']):.2g}" if paired else "-", pair(o["iterations"], 2) if paired else "-",
                        f"{100 * math.expm1(time):+.1f} ± {100 * error:.1f} %" if paired else "-", str(len(o["iterations"]))])
    text += "\n\n" + table(["chart", "minimum found, 95 % interval", "only this chart, only `standard`", "p", "steps more than `standard`", "time relative to `standard`", "pairs"], summary)
    cpu = sum(s.get("cpu", 0) for s in used)
    return text + f"\n\n{len(used)} searches with {seeds} seeds, {cpu / 60:.0f} minutes of processor time, filters included."


def monte_carlo(scene, runs):
    folder = OUT / f"{scene}-{runs}"
    chasles("montecarlo", scene, *[a for s in SHORT[scene] for a in ("--scene-set", s)], "--runs", runs, "--workers", 1, "--charts", ",".join(CHARTS),
            "--estimators", "filter,batch", "--set", "batch.loss=none", "--set", "batch.gate=0", "--resume", "--quiet", "--json", "-o", folder)
    trials = {}
    for line in (folder / "trials.jsonl").read_text().splitlines():
        t = json.loads(line)
        trials.setdefault(t["filter"], {})[t["run"]] = t
    filters = {f["filter"]: f for f in json.loads((folder / "summary.json").read_text())["filters"]}
    ate = lambda name, run: trials[name][run]["ate_posyaw_m"]
    rows, names = [], [f for f in filters if not f.endswith("+batch")]
    for name in names:
        f, b = filters[name], filters[name + "+batch"]
        both = [r for r in sorted(trials[name]) if not trials[name][r]["diverged"] and not trials[name + "+batch"][r]["diverged"]]
        differences = [ate(name + "+batch", r) - ate(name, r) for r in both]
        apart = max(abs(ate(name + "+batch", r) - ate(names[0] + "+batch", r)) for r in both)
        rows.append([f"{scene}, `{f['chart']}`", f"{f['ate_posyaw_m']:.4f} → {b['ate_posyaw_m']:.4f}", pair(differences, 4),
                     f"{sum(d > 0 for d in differences)}/{len(both)}", f"{f['nees_pose_per_dof']:.3f} → {b['nees_pose_per_dof']:.3f}",
                     f"{f['nees_state'] / 15:.3f} → {b['nees_state'] / 15:.3f}", f"{b['band'][0]:.3f} to {b['band'][1]:.3f}",
                     f"{100 * f['seconds_inside_band']:.0f} → {100 * b['seconds_inside_band']:.0f} %", f"{apart:.0e}"])
    return rows


def consistency(runs):
    rows = [row for scene in SHORT for row in monte_carlo(scene, runs)]
    return table(["scene, chart", "position-and-heading ATE, filter → batch [m]", "batch − filter [m]", "batch worse", "pose NEES / dof",
                  "state NEES / dof", "95 % band", "seconds inside the band", "largest ATE difference from `standard`'s batch [m]"], rows)


def main():
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 10
    runs = int(sys.argv[2]) if len(sys.argv) > 2 else 100
    OUT.mkdir(parents=True, exist_ok=True)
    simulated()
    if seeds > 0:
        fill(PAGE, "basin", basin(seeds))
    if runs > 0:
        fill(PAGE, "consistency", consistency(runs))


main()
