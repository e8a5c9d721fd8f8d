#!/usr/bin/env python3
"""python3 -m studies.drift: errors of filter and batch on the KITTI tracks, by time span. An ATE mixes a
heading error with errors in metres. This script prints the errors of the motion over fixed time
spans, batch against filter, over all recordings, for studies/batch.md. Recordings of the same drive
count as one in the mean and its error. Needs numpy (`make dev-deps`)."""

import math

import numpy as np

from studies.trajectories import angle, by_drive, drives, errors, mean_and_error, runs_of

SPANS = [0.1, 1, 5, 10, 20]  # [s]


def main():
    spans = {s: {"names": [], "translation": [], "rotation": []} for s in SPANS}
    for name, arguments in drives():
        truth, runs = runs_of(name, arguments)
        n, period = len(truth.t), np.median(np.diff(truth.t))
        for span in SPANS:
            k = max(1, round(span / period))
            if n <= 2 * k:
                continue
            spans[span]["names"].append(name)
            begin = np.arange(n - k)
            rms = {}
            for e, r in runs.items():
                R, p = errors(r, truth, begin, begin + k)
                rms[e] = {"rotation": math.sqrt(np.mean(angle(R) ** 2)), "translation": math.sqrt(np.mean(np.sum(p * p, axis=1)))}
            for of in ("translation", "rotation"):
                spans[span][of].append(math.log(rms["batch"][of] / rms["filter"][of]))
    print("| over | translation, log of batch / filter | worse in | rotation | worse in |\n| --- | --- | --- | --- | --- |")
    for span in SPANS:
        cells = []
        for of in ("translation", "rotation"):
            logs = spans[span][of]
            mean, error = mean_and_error(by_drive(spans[span]["names"], logs))
            cells += [f"{mean:+.3f} ± {error:.3f}", f"{sum(l > 0 for l in logs)} of {len(logs)}"]
        print(f"| {span:g} s | " + " | ".join(cells) + " |")


main()
