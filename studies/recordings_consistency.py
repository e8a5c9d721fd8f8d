#!/usr/bin/env python3
"""python3 -m studies.recordings_consistency [--quick] [--only PATTERN] [--set KEY=VALUE]... [--recording NAME=PATH]...:
are the covariances consistent with the errors? It runs the filter, window:20 and batch with default settings on all
development recordings, real and rendered, four draws each, and compares errors and sigmas of the filter's path, its
smoothed path and the two others (studies/recordings-consistency.md). It writes out/recordings-consistency/table.md, and
the figures of each run to out/recordings-consistency/runs. `make recordings-consistency` also installs smfeval, without
which there are no scores (tools/studies-venv).

An interrupted call resumes: a run counts as done if program, recording and options are the same.
A rendered recording is kept until the sources of the renderer change, or for want of room.

--quick has only the filter, one draw, the real recordings and the demo's walk. --only takes the recordings
whose names match the regular expression. --recording adds one of your own. --set is passed on to
all runs. --page also fills studies/recordings-consistency.md with the table."""

import argparse
import concurrent.futures
import pathlib
import re
import signal
import statistics
import subprocess
import sys
import typing

from studies import pages
from studies.consistency_runs import (SCORER, Recording, Store, estimate, lock, real_recordings, rendered_recordings,
                                      stop)
from studies.pages import fill
from studies.program import CHASLES, ROOT, Json, count, parser, sets

PAGE = ROOT / "studies/recordings-consistency.md"
MARKERS = {PAGE: ("recordings-consistency",)}
ESTIMATORS = ("filter", "window:20", "batch")
DRAWS = 4
WORKERS = 2
SMOOTHED = "smoothed path"  # of the filter
AXES = ("rx", "ry", "rz", "x", "y", "z")
Values = typing.Sequence[float]
# The goal's name, its condition on the means over the draws, the figures that it applies to.
GOALS: tuple[tuple[str, typing.Callable[[Values], bool], tuple[str, ...]], ...] = (
    ("NEES/dof of position and attitude in 0.5 to 2", lambda x: 0.5 <= min(x) and max(x) <= 2,
     ("position", "attitude")),
    ("NEES/dof of the pose in 0.5 to 2, truth's errors unknown", lambda x: 0.5 <= x[0] <= 2, ("pose",)),
    ("NEES/dof of the pose in 0.5 to 2, truth's errors known", lambda x: 0.5 <= x[0] <= 2, ("known",)),
    ("within 3 sigma at least 98 % on every axis", lambda x: x[0] >= 0.98, ("least",)),
    ("|scale − 1| at most 2 of its sigmas", lambda x: abs(x[0] - 1) <= 2 * x[1], ("scale", "scale_sigma")),
    ("NIS/dof in 0.8 to 1.25", lambda x: 0.8 <= x[0] <= 1.25, ("nis",)),
    ("|correlation| at most 0.15", lambda x: abs(x[0]) <= 0.15, ("correlation",)))


class Run(typing.NamedTuple):
    recording: Recording
    variant: str
    estimator: str
    draw: int
    options: list[str]

    def title(self) -> str:
        return self.recording.name + (f", {self.variant}" if self.variant else "")


class Row:
    """A line of the table: one path of an estimator on a recording, in all its draws."""

    def __init__(self, title: str, path: str, draws: list[Json]) -> None:
        self.title, self.path = title, path
        self.draws = [figures_of(draw, smoothed=path == SMOOTHED) for draw in draws]

    def values(self, name: str) -> list[float]:
        return [draw[name] for draw in self.draws if draw[name] is not None]

    def mean(self, name: str) -> float | None:
        values = self.values(name)
        return statistics.fmean(values) if values else None

    def state(self) -> str:
        """The health of the draws, or why they have no figures."""
        states = [draw["state"] for draw in self.draws]
        known = list(dict.fromkeys(states))
        return ", ".join(s if len(known) == 1 else f"{states.count(s)} {s}" for s in known).replace("|", "\\|")

    def cells(self) -> list[str]:
        return [self.title, self.path if self.path == SMOOTHED else f"`{self.path}`",
                *(spread(self.values(name), digits, factor) for _, name, digits, factor in COLUMNS), self.state()]


class Plan:
    """The runs of a call."""

    def __init__(self, store: Store, recordings: list[Recording], estimators: tuple[str, ...], settings: list[str],
                 draws: int) -> None:
        self.store, self.draws, self.done = store, draws, 0
        self.runs = [Run(r, variant, estimator, draw,
                         ["--estimator", estimator, *options, *r.options(draw), *sets(*settings)])
                     for r in recordings
                     for variant, options in r.variants.items()
                     for estimator in estimators
                     for draw in range(1, draws + 1)]

    def result(self, run: Run) -> Json | None:
        return self.store.result(self.store.key(run.recording, run.draw, run.options))

    def is_missing(self, run: Run) -> bool:
        result = self.result(run)
        return not result or str(result.get("problem", "")).startswith("not rendered")

    def jobs(self) -> list[list[Run]]:
        """The missing runs; those that need one and the same rendered recording together."""
        found: dict[tuple[str, int], list[Run]] = {}
        for run in filter(self.is_missing, self.runs):
            shared = run.recording.render and not run.recording.seeded
            found.setdefault((run.recording.name, 0 if shared else run.draw), []).append(run)
        return list(found.values())

    def work(self, job: list[Run]) -> None:
        recording, draw = job[0].recording, job[0].draw
        render = recording.rendering(draw)
        path, problem = self.store.rendered(recording, draw, render) if render else (recording.path, None)
        for run in job:
            result: Json = {"problem": problem} if problem else estimate(path, run.options)
            result |= {"recording": recording.name, "variant": run.variant, "estimator": run.estimator,
                       "draw": run.draw, "options": run.options}
            self.store.keep(self.store.key(recording, run.draw, run.options), result)
            with lock:
                self.done += 1
                print(f"{run.title()}, {run.estimator}, draw {run.draw}: {result.get('problem') or 'done'}", flush=True)
        if render:
            self.store.release(recording, draw)

    def run(self, workers: int) -> None:
        with concurrent.futures.ThreadPoolExecutor(workers) as pool:
            for work in [pool.submit(self.work, job) for job in self.jobs()]:
                work.result()

    def rows(self) -> list[Row]:
        """In the order of the runs; behind each row of the filter that of its smoothed path, if a run has one."""
        found: dict[tuple[str, str], list[Json]] = {}
        for run in self.runs:
            result = self.result(run) or {"problem": "not run"}
            paths = (run.estimator, SMOOTHED) if run.estimator == "filter" else (run.estimator,)
            for path in paths:
                found.setdefault((run.title(), path), []).append(result)
        return [Row(title, path, draws) for (title, path), draws in found.items()
                if path != SMOOTHED or any("smoothed" in draw for draw in draws)]


def figures_of(result: Json, smoothed: bool = False) -> Json:
    """The figures of the table by name; None where a run has none."""
    run = result.get("path", {})
    f = result.get("smoothed", {}) if smoothed else run
    shares = [f[name] for axis in AXES if f.get(name := f"within_3_sigma_{axis}") is not None]
    scores, known = f.get("scores", {}), f.get("known", {}).get("truth_errors", {}).get("nees_pose", {})

    def per_dof(name: str, dof: int) -> float | None:
        return None if f.get(name) is None else f[name] / dof

    return {
        "ate": f.get("ate_posyaw_m"), "degrees": f.get("attitude_posyaw_deg"), "position": per_dof("nees_position", 3),
        "attitude": per_dof("nees_attitude", 3), "pose": per_dof("nees_pose", 6),
        "known": None if known.get("mean") is None else known["mean"] / known["dof"],
        **{name: scores.get(name) for name in ("k", "coverage", "crps", "scale")},
        "scale_sigma": f.get("scale_sigma"), "nis": f.get("nis_per_dof"),
        "correlation": f.get("innovation_correlation"), "least": min(shares) if shares else None, "ms": cost(run),
        "state": result.get("problem") or f.get("note") or run.get("health", "")
    }


def cost(figures: Json) -> float | None:
    """Processor time of the whole run per frame [ms], which other programs change less than its wall time."""
    return 1e3 * figures["seconds_cpu"] / figures["frames"] if figures.get("frames") else None


# The column's title, the figure, its digits, and the factor to the column's unit.
COLUMNS: tuple[tuple[str, str, int, float], ...] = (
    ("ATE m", "ate", 3, 1), ("attitude °", "degrees", 2, 1), ("NEES/dof position", "position", 2, 1),
    ("attitude", "attitude", 2, 1), ("pose", "pose", 2, 1), ("pose, truth's errors known", "known", 2, 1),
    ("k", "k", 2, 1), ("90 % coverage", "coverage", 0, 100), ("CRPS mm", "crps", 1, 1000), ("scale", "scale", 3, 1),
    ("its sigma", "scale_sigma", 3, 1), ("NIS/dof", "nis", 2, 1), ("correlation", "correlation", 2, 1),
    ("least within 3σ %", "least", 1, 100), ("CPU ms a frame", "ms", 1, 1))


def spread(values: Values, digits: int, factor: float = 1) -> str:
    """Mean ± standard deviation over the draws, the latter of two or more."""
    if not values:
        return "-"
    mean = f"{factor * statistics.fmean(values):.{digits}f}"
    return mean + (f" ± {factor * statistics.stdev(values):.{digits}f}" if len(values) > 1 else "")


def table(rows: list[Row]) -> str:
    header = ("recording", "path", *(title for title, *_ in COLUMNS), "state")
    return pages.table(header, [row.cells() for row in rows], ["---", "---", *["---:"] * len(COLUMNS), "---"])


def goals(rows: list[Row]) -> str:
    """For each goal the number of rows that meet it, and those that do not."""
    lines = ["| goal | met | not met by |", "|---|---:|---|"]
    for name, holds, of in GOALS:
        met, all_of = 0, 0
        missed: list[str] = []
        for row in rows:
            values = [mean for figure in of if (mean := row.mean(figure)) is not None]
            if len(values) < len(of):
                continue
            all_of += 1
            if holds(values):
                met += 1
            else:
                missed.append(f"{row.title} {row.cells()[1]}")
        by = ("; ".join(missed) if met else "all") if missed else "-"
        lines.append(pages.row([name.replace("|", "\\|"), f"{met} of {all_of}", by]))
    return "\n".join(lines)


def commit() -> str:
    done = subprocess.run(["git", "-C", ROOT, "describe", "--always", "--dirty"], stdout=subprocess.PIPE,
                          stderr=subprocess.DEVNULL, text=True)
    return done.stdout.strip() or "no commit"


def arguments() -> argparse.Namespace:
    known = parser(__doc__)
    known.add_argument("--quick", action="store_true")
    known.add_argument("--only", default="", metavar="PATTERN")
    known.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    known.add_argument("--recording", action="append", default=[], metavar="NAME=PATH")
    known.add_argument("--draws", type=count, metavar="N", help=f"{DRAWS}; 1 with --quick")
    known.add_argument("--workers", type=count, default=WORKERS, metavar="N", help=f"runs in parallel, {WORKERS}")
    known.add_argument("--page", action="store_true")
    known.add_argument("-o", "--output", type=pathlib.Path, default=ROOT / "out/recordings-consistency", metavar="DIR")
    found = known.parse_args()
    if found.draws is None:
        found.draws = 1 if found.quick else DRAWS
    for name in ("draws", "workers"):
        if getattr(found, name) == 0:
            known.error(f"--{name}: found 0, expected 1 or more")
    return found


def recordings_of(o: argparse.Namespace) -> list[Recording]:
    found = real_recordings() + [r for r in rendered_recordings() if not o.quick or r.name.startswith("demo")]
    for own in o.recording:
        name, equals, path = own.partition("=")
        if not equals or not pathlib.Path(path).exists():
            sys.exit(f"studies/recordings_consistency.py: --recording: found '{own}', expected NAME=PATH of a "
                     "recording")
        found.append(Recording(name, pathlib.Path(path).resolve()))
    try:
        chosen = [r for r in found if re.search(o.only, r.name, re.IGNORECASE)]
    except re.error as error:
        sys.exit(f"studies/recordings_consistency.py: --only: '{o.only}' is no regular expression: {error}")
    if not chosen:
        sys.exit(f"studies/recordings_consistency.py: no recording matches '{o.only}'; "
                 f"there are {', '.join(r.name for r in found)}")
    return chosen


def main() -> None:
    o = arguments()
    if not CHASLES.exists():
        sys.exit(f"studies/recordings_consistency.py: there is no {CHASLES}: run `make build`, or set CHASLES_BINARY")
    recordings = recordings_of(o)
    if not SCORER.exists():
        print(f"there is no {SCORER}: without scores, see tools/studies-venv", file=sys.stderr)
    for kind in (signal.SIGINT, signal.SIGTERM):
        signal.signal(kind, stop)
    plan = Plan(Store(o.output, o.workers), recordings, ESTIMATORS[:1] if o.quick else ESTIMATORS, o.set, o.draws)
    try:
        plan.run(o.workers)
    except KeyboardInterrupt:
        sys.exit("studies/recordings_consistency.py: interrupted; the same command resumes")
    rows = plan.rows()
    settings = "".join(f", `{s}`" for s in o.set) or ", default settings"
    page = (f"Commit {commit()}, program {plan.store.program[:12]}{settings}, draws: {o.draws}.\n\n"
            f"{table(rows)}\n\n{goals(rows)}\n")
    (o.output / "table.md").write_text(page)
    if o.page:
        fill(PAGE, "recordings-consistency", page.strip())
    print(f"{page}\n{plan.done} of {len(plan.runs)} runs made now, the others before: {o.output / 'table.md'}")


if __name__ == "__main__":
    main()
