#!/usr/bin/env python3
"""python3 -m studies.crossvalidate [--only SETTING] [--page]: are the defaults of stereo-velocity runs right for
drives that did not choose them? For each setting it runs the filter with several values on all KITTI
tracks. The other drives choose the value for each drive, and the table has the change against the
default on the drives left out (studies/noise.md, "Cross-validation"). It writes out/crossvalidate/table.md.
--page also fills studies/noise.md.

The nine STARS drives are there twice more, with the noise and biases of the 2020 sets added to their
velocities. out/crossvalidate/runs keeps the runs, whatever the program and its defaults: remove it
after a change. The script needs numpy, scipy and half an hour of processor time."""

import argparse
import concurrent.futures
import json
import math
import pathlib
import subprocess
import warnings

import numpy as np
import scipy.io

from studies.pages import fill
from studies.trajectories import CHASLES, DATA, DRIVE, ROOT, drives, run_folder

OUT = ROOT / "out/crossvalidate"
PAGE = ROOT / "studies/noise.md"
SECONDS_EACH = 120  # of a run
SEEDS = (1, 2)  # of the noise
NOISE = {"v_vk_vk_i": 0.5, "w_vk_vk_i": 0.05}  # of a sample [m/s, rad/s], as in the 2020 sets
BIAS = (0.005, 0.01)  # of the gyroscope, in size [rad/s]
FIGURES = ("ate_m", "attitude_deg", "rpe_100m_percent")  # lower is better; equal weights

# A value, or several settings that belong together. The default is a candidate of every row.
CANDIDATES = {
    "updates_per_frame": ["0", "100", "50", "30", "20", "10", "5"],
    "disparity_sigma": ["0.3", "0.6", "0.8", "1.6"],
    "pixel_sigma": ["1", "1.5", "3", "4", "8"],
    "updates_per_frame, disparity_sigma": ["30, 0.6", "20, 0.6", "20, 0.8", "10, 0.6", "10, 0.8"],
    "updates_per_frame, pixel_sigma": ["30, 3", "20, 3", "20, 4", "10, 3", "10, 4"],
    "gate": ["0.5", "0.7", "0.9", "0.99"],
    "gate_quorum": ["5", "10", "20", "30"],
    "stereo_rows": ["all", "mean+disparity"],
    "waiting_landmarks": ["0", "12", "48"],
    "min_disparity": ["0.5", "2", "4"],
    "velocity": ["input"],
    "velocity_sigma": ["0.05", "0.2", "0.4", "0.7"],
    "velocity_relative_sigma": ["0", "0.01", "0.02"],
    "velocity_walk": ["0.2", "0.5", "1", "2"],
    "rate_sigma": ["0.001", "0.003", "0.03", "0.07"],
    "rate_walk": ["0.025", "0.05", "0.1", "0.2"],
    "gyro_bias_sigma": ["0", "0.0001", "0.003", "0.01"],
    "gyro_bias_walk": ["0", "0.00001", "0.0001"],
    "velocity_scale": ["true"],
    "tilt_walk": ["0.0003", "0.003"],
    "velocity_heading_sigma": ["0", "0.002", "0.005"],
    "time_offset": ["auto", "0.05"],
}


def noisy(recording, folder):
    """Copies of a STARS file with noise in its velocities."""
    for seed in SEEDS:
        path = folder / f"{recording.stem.replace('_sync_KLT', '')}, noise {seed}.mat"
        if not path.exists():
            content = {k: v for k, v in scipy.io.loadmat(recording).items() if not k.startswith("__")}
            random = np.random.default_rng([seed, int("".join(filter(str.isdigit, recording.stem)))])
            for name, sigma in NOISE.items():
                content[name] = content[name] + sigma * random.standard_normal(content[name].shape)
            content["w_vk_vk_i"] += random.uniform(*BIAS, (3, 1)) * random.choice([-1, 1], (3, 1))
            scipy.io.savemat(path, content)
        yield path


def recordings():
    """Name: drive, whether the velocities are noisy, arguments of `run`."""
    folder = OUT / "recordings"
    folder.mkdir(parents=True, exist_ok=True)
    found = {name: (DRIVE.get(name, name.split("/")[1]), "2020" in name, arguments) for name, arguments in drives() if "dataset3" not in name}
    for name, (drive, _, arguments) in list(found.items()):
        if name.startswith("stars/"):
            found.update({path.stem: (drive, True, [path]) for path in noisy(arguments[0], folder)})
    return found


def options(setting, value):
    """None for the default, which is ""."""
    pairs = zip(setting.split(", "), value.split(", ")) if value else []
    return [argument for pair in pairs for argument in ("--set", "=".join(pair))]


def summary(name, arguments, setting, value):
    folder = run_folder(OUT / "runs", name, f"{setting}={value}" if value else "default")
    if not (folder / "summary.json").exists():
        command = [CHASLES, "run", *arguments, *options(setting, value), "--quiet", "--threads", "1", "-o", folder]
        subprocess.run([str(a) for a in command], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, timeout=SECONDS_EACH)
    return json.loads((folder / "summary.json").read_text())


def ratios(of, default):
    """Logarithms of the figures against the default, and that of the pose NEES."""
    pairs = [(of.get(f), default.get(f)) for f in FIGURES]
    return [math.log(a / b) if a and b else math.nan for a, b in pairs] + [math.log(of["nees_pose"] / default["nees_pose"])]


class Study:
    def __init__(self, found, runs):
        self.found, self.runs = found, runs
        self.drives = sorted({drive for drive, _, _ in found.values()})

    def change(self, setting, value, drive, kinds=(False, True)):
        """Mean of a drive's recordings: every figure, NEES."""
        rows = [ratios(self.runs[name, setting, value], self.runs[name, "", ""])
                for name, (of, kind, _) in self.found.items() if of == drive and kind in kinds]
        return np.nanmean(rows, axis=0) if rows else None

    def best(self, setting, among):
        def score(value):
            return np.mean([np.nanmean(self.change(setting, value, drive)[:-1]) if value else 0 for drive in among])
        return min(["", *CANDIDATES[setting]], key=score)

    def row(self, setting):
        chosen = {drive: self.best(setting, [d for d in self.drives if d != drive]) for drive in self.drives}
        of_all = self.best(setting, self.drives)
        cells = [setting, ", ".join(f"`{v}`" for v in CANDIDATES[setting]), f"`{of_all}`" if of_all else "default", f"{sum(v == of_all for v in chosen.values())} of {len(chosen)}"]
        for kind in (False, True):
            found = [self.change(setting, chosen[d], d, (kind,)) if chosen[d] else np.zeros(len(FIGURES) + 1) for d in self.drives
                     if any(of == d and k == kind for of, k, _ in self.found.values())]
            cells += [self.cell(column) for column in np.transpose(found)]
        return cells

    @staticmethod
    def cell(values):
        values = values[np.isfinite(values)]
        if not np.any(values):
            return "0"
        return f"{np.mean(values):+.2f} ± {np.std(values, ddof=1) / math.sqrt(len(values)):.2f}".replace("-", "−")


def main():
    warnings.filterwarnings("ignore", "Mean of empty slice")  # a figure that no recording of a drive has
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--page", action="store_true")
    parser.add_argument("--only", default="", help="a setting")
    arguments = parser.parse_args()
    found = recordings()
    wanted = [s for s in CANDIDATES if arguments.only in s]
    jobs = [(name, "", "") for name in found] + [(name, s, v) for s in wanted for v in CANDIDATES[s] for name in found]
    with concurrent.futures.ThreadPoolExecutor(2) as workers:
        runs = dict(zip(jobs, workers.map(lambda job: summary(job[0], found[job[0]][2], job[1], job[2]), jobs)))
    study = Study(found, runs)
    figures = "ATE | attitude | 100 m | NEES"
    lines = [f"| setting | values besides the default | chosen by all | chosen by the others | recorded velocities: {figures} | noisy velocities: {figures} |", "|" + " --- |" * 12]
    lines += ["| " + " | ".join(study.row(s)) + " |" for s in wanted]
    (OUT / "table.md").write_text("\n".join(lines) + "\n")
    print("\n".join(lines))
    if arguments.page:
        fill(PAGE, "crossvalidation", "\n".join(lines))


if __name__ == "__main__":
    main()
