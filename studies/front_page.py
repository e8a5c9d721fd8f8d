#!/usr/bin/env python3
"""python3 -m studies.front_page: README.md, docs/results.md and studies/results.md say what
studies/results.json says. Measures nothing: `make table` and `make pictures` fill that file and then
call this. A sentence takes its figures from one run each, so it cannot pair those of two.
tests/readme_test.py compares the pages with the file."""

import json
import math
import pathlib
import re
import textwrap
import typing

from studies.kitti import short_name
from studies.pages import fill, padded_table
from studies.program import ROOT, Json, parser, read_json

RESULTS = ROOT / "studies/results.json"
README, STEREO = ROOT / "README.md", ROOT / "docs/results.md"
VARIANTS, PEERS = ROOT / "studies/results.md", ROOT / "studies/peers.md"  # whole pages

DEFAULT, DEAD = "right-sen3 (default)", "dead reckoning"
CAMERAS = {1: "one camera", 2: "two cameras"}
AXES = ("rx", "ry", "rz", "x", "y", "z")
NO_RESULT = "-"

Figures = float | list[float]  # of one run, or the least and the greatest of several
Text = typing.Callable[[float], str]

# Of the page of all variants: heading, name in the results, digits.
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


def load() -> Json:
    results: Json = read_json(RESULTS)
    return results


def save(results: Json) -> None:
    RESULTS.write_text(json.dumps(results, indent=1, ensure_ascii=False) + "\n")


# ---- Text

def wrap(text: str) -> str:
    """Paragraphs of at most 100 characters; a list's items hang."""
    paragraphs = []
    for paragraph in text.strip().split("\n\n"):
        lines: list[str] = []
        for item in paragraph.split("\n- "):
            first = "- " if lines or item.startswith("- ") else ""
            item = " ".join(item.removeprefix("- ").split())
            # A number and its unit stay on one line.
            item = re.sub(r"(\d) ((?:ms|mm|m|MB|s|%)(?!\w))", "\\1\0\\2", item)
            lines.append(textwrap.fill(item, 100, initial_indent=first, subsequent_indent=" " * len(first),
                                       break_long_words=False, break_on_hyphens=False).replace("\0", " "))
        paragraphs.append("\n".join(lines))
    return "\n\n".join(paragraphs)


def cell(figures: Json, figure: str, digits: int) -> str:
    value = figures.get(figure)
    if not isinstance(value, (int, float)):
        return "diverged" if figures.get("exit_code") == 4 and figure == "ate_m" else NO_RESULT
    if abs(value) >= 1e5:
        return f"{value:.0e}"
    return f"{value:.{0 if abs(value) >= 1000 else digits}f}"


def metres(value: float) -> str:
    return f"{value:.{4 if value < 0.02 else 3}f}"


def several(value: Figures, text: Text) -> str:
    low, high = value if isinstance(value, list) else (value, value)
    return text(low) if text(low) == text(high) else f"{text(low)}–{text(high)}"


# ---- What a sentence may state of one run

class InertialRun:
    """A row of `visual_inertial` in the results: one recording with one or two cameras."""

    def __init__(self, row: Json) -> None:
        own = row["chasles"]
        self.row = row
        self.name = row["name"]
        self.cameras = CAMERAS.get(row["cameras"], NO_RESULT)
        self.seconds = f"{own['recorded_seconds']:.1f}"
        self.mm = f"{1000 * own['compared']['ate_posyaw_m']:.0f}"
        self.m = metres(own["compared"]["ate_posyaw_m"])
        self.smoothed = metres(own["compared"]["smoothed_ate_posyaw_m"])
        # The greatest of several measurements.
        self.ms = several(row["cpu_ms"]["Chasles"][-1], "{:.1f}".format) if "cpu_ms" in row else NO_RESULT
        self.sigmas = sigmas(own)
        self.inside = f"{100 * min(own[f'within_3_sigma_{axis}'] for axis in AXES):.0f}"


def sigmas(figures: Json) -> str:
    """How large the errors of the pose are in units of their sigmas: 1 if consistent."""
    return f"{math.sqrt(figures['nees_pose'] / 6):.1f}"


def inertial(results: Json) -> dict[tuple[str, int], InertialRun]:
    return {(row["key"], row["cameras"]): InertialRun(row) for row in results["visual_inertial"]["rows"]}


def stereo_range(results: Json, figure: str, text: Text) -> dict[str, str]:
    values = [runs[DEFAULT][figure] for runs in results["stereo_velocity"]["runs"].values()]
    return {"least": text(min(values)), "most": text(max(values))}


# ---- README.md

CLAIM = """**Visual-inertial SLAM in C++20: {run.mm} mm error in {run.seconds} s of {run.name} with
{run.cameras}, at {run.ms} ms of processor time a frame. Stereo tracks with velocities run at {speed[least]}
to {speed[most]} times real time.**"""


def claim(results: Json) -> str:
    speed = stereo_range(results, "realtime_factor", "{:.0f}".format)
    return wrap(CLAIM.format(run=inertial(results)["MH_01", 2], speed=speed))


def ate_cell(value: Figures | Json | None) -> str:
    if value is None:
        return NO_RESULT
    if isinstance(value, dict):
        return value["text"] if "text" in value else several(value["m"], metres)
    return several(value, metres)


def nees_text(value: float) -> str:
    return f"{value:.{1 if value < 10 else 0}f}"


def ms_text(value: float) -> str:
    return f"{value:.{1 if value < 20 else 0}f}"


def comparison(results: Json) -> str:
    peers = list(results["visual_inertial"]["peers"]["programs"])
    rows = []
    for row in results["visual_inertial"]["rows"]:
        own = metres(row["chasles"]["compared"]["ate_posyaw_m"])
        rows.append([f"ATE m, {row['name']}, {row['chasles']['recorded_seconds']:.1f} s", f"{row['cameras']:.0f}", own,
                     *[ate_cell(row["ate_m"].get(p)) for p in peers]])
    for row in results["visual_inertial"]["rows"]:
        rows.append([f"pose NEES, {row['name']}", f"{row['cameras']:.0f}", nees_text(row["chasles"]["nees_pose"]),
                     *[several(row["nees"][p], nees_text) if p in row["nees"] else NO_RESULT for p in peers]])
    for row in results["visual_inertial"]["rows"]:
        if "cpu_ms" in row:
            rows.append([f"CPU ms a frame, {row['name']}", f"{row['cameras']:.0f}",
                         *[several(row["cpu_ms"][p], ms_text) if p in row["cpu_ms"] else NO_RESULT
                           for p in ["Chasles", *peers]]])
    return padded_table(["real images", "cameras", "Chasles", *peers], rows)


NOTES = """ATE is by `chasles evaluate`, aligned by position and yaw; CPU times are without image decoding, at
Chasles {timed}; Basalt's of another hour. A NEES of 6 is consistent. The peers are {versions}, with
online calibration off and the IMU noise that each ships; ORB-SLAM3 has its path after the run.
[studies/peers.md](studies/peers.md) has the conditions, and what "late" and "in part" mean."""


def notes(results: Json) -> str:
    peers = results["visual_inertial"]["peers"]
    return wrap(NOTES.format(timed=peers["chasles"], versions=versions(peers)))


def versions(peers: Json) -> str:
    *first, last = [f"{name} {program['version']}" for name, program in peers["programs"].items()]
    return f"{', '.join(first)} and {last}"


COVARIANCE = """**The covariance** holds on some recordings and not on others. The errors of the pose are
{walk} times their sigmas on the rendered walk of `make demo`, {mono.sigmas} and {stereo.sigmas} times on
{mono.name} with one camera and with two, and all poses are within 3σ. They are {fast.sigmas} times
their sigmas on {fast.name} ({fast.inside} % within 3σ on the worst axis), {kitti.sigmas} times on
{kitti.name}, and {stereo_runs[least]} to {stereo_runs[most]} times in runs with velocities:
[docs/recordings-consistency.md](docs/recordings-consistency.md)."""


def covariance(results: Json) -> str:
    runs = inertial(results)
    exact = [runs["MH_01", 1].row["chasles"], runs["MH_01", 2].row["chasles"], results["walk"]]
    if any(run[f"within_3_sigma_{axis}"] < 1 for run in exact for axis in AXES):
        raise SystemExit("studies/front_page.py: not every pose lies within 3 sigmas: change COVARIANCE")
    stereo = stereo_range(results, "nees_pose", lambda nees: f"{math.sqrt(nees / 6):.1f}")
    return wrap(COVARIANCE.format(walk=sigmas(results["walk"]), mono=runs["MH_01", 1], stereo=runs["MH_01", 2],
                                  fast=runs["MH_03", 1], kitti=runs["KITTI 00", 2], stereo_runs=stereo))


LOOP = """The picture has {loop[path_m]:.0f} m around a block, {loop[rounds]:.0f} times, with errors drawn
{loop[factor]:.0f} times as large. The ATE is {loop[without][ate_m]:.2f} m without recognition and
{loop[with][ate_m]:.3f} m with it; that of the smoothed path {loop[without][smoothed_ate_m]:.2f} m and
{loop[with][smoothed_ate_m]:.3f} m."""


def loop(results: Json) -> str:
    return wrap(LOOP.format(loop=results["loop"]))


LIMITS = """- **Dense maps, GNSS, lidar**, or body velocities and an IMU in one run.
- **Constant memory with the filter:** {memory[Chasles]:.0f} MB after {memory[seconds]:.0f} s of a rendered walk,
  {memory[window:20]:.0f} MB with `window:20`, about {memory[peers]:.0f} MB with OpenVINS and sqrtVINS.
- **The least error everywhere.** On another {other[seconds]:.0f} s of {other[name]}, one camera, the filter of
  {of} had {other[Chasles]:.3f} m, the batch {other[batch]:.3f} m, and sqrtVINS {other[sqrtVINS]:.3f} m. On the
  {late[frames]:.0f} frames of {kitti.name} that OpenVINS estimates it has {late[m]:.3f} m, Chasles
  {late[chasles_there_m]:.3f} m.
- **Recognition in a sliding window**, which keeps no past landmarks."""


def limits(results: Json) -> str:
    peers = results["visual_inertial"]["peers"]
    kitti = inertial(results)["KITTI 00", 2]
    return wrap(LIMITS.format(memory=peers["memory_mb"], other=peers["other_cut"], of=peers["chasles"], kitti=kitti,
                              late=kitti.row["ate_m"]["OpenVINS"]))


# ---- studies/peers.md

PEERS_HEAD = """# Peers on the same recordings

This page compares Chasles with other programs on recordings of real images. `make table` writes it
from `studies/results.json`. It measures Chasles again; the figures of the peers stay.

- Peers: {versions}, run offline. Their figures and all times are of one comparison beside Chasles
  {timed}: {source}. Those of Basalt are of
  {basalt}. In turns with it, Chasles took {basalt_mono} ms a frame with one camera and {basalt_stereo} with
  two.
- ATE and attitude are by `chasles evaluate`, aligned by position and yaw. On EuRoC they count from
  {after:.1f} s on, so that no late start gains.
- Online calibration is off, and the IMU noise is that which each program ships. {conditions}
- Times are processor time, without image decoding; those of Chasles without smoothing.
- ORB-SLAM3 has its path after the run. It and Basalt state no covariance.
- Chasles: {measured}."""

PEERS_TAIL = """- *MH_01.* With one camera, ORB-SLAM3 loses {lost:.0f} of {lost_of:.0f} runs.
- *MH_03.* With its online calibration, OpenVINS has {calibrated} m. ORB-SLAM3 tracks {tracked} of
  {of_frames} frames. Basalt starts with velocity zero and the first sample of the IMU, and this recording
  begins in flight. Begun up to {basalt_late} s later, {basalt_good} of {basalt_starts} runs of Basalt have
  {basalt_fast} m, and the others diverge.
- *KITTI.* OpenVINS starts at {start:.1f} s, with {openvins} m on its {openvins_frames} frames; Chasles has
  {openvins_own} m there. sqrtVINS does not start. ORB-SLAM3 has {orb} m on {orb_frames} of {kitti_frames}
  frames; Chasles has {orb_own} m there. The start of Basalt takes a wrong vertical from the car's
  acceleration: aligned in all directions it has {basalt_kitti} m.
- *Another {cut[seconds]:.0f} s of {cut[name]}*, one camera: the filter of {timed} has {cut[Chasles]:.3f} m, its
  smoothed path {cut[smoothed]:.3f}, `window:20` {cut[window:20]:.3f} and the batch {cut[batch]:.3f}; sqrtVINS has
  {cut[sqrtVINS]:.3f} and OpenVINS {cut[OpenVINS]:.3f}.
- *Memory* on a rendered walk of {memory[seconds]:.0f} s: Chasles {memory[Chasles]:.0f} MB, with `window:20`
  {memory[window:20]:.0f} MB, OpenVINS and sqrtVINS about {memory[peers]:.0f} MB."""


def peers_page(results: Json) -> str:
    part = results["visual_inertial"]
    peers, runs = part["peers"], inertial(results)
    own = padded_table(
        ["Chasles", "cameras", "path m", "ATE m", "smoothed m", "attitude °", "within 3σ, worst axis %"],
        [[run.name, f"{run.row['cameras']:.0f}", f"{run.row['chasles']['path_m']:.1f}", run.m, run.smoothed,
          f"{run.row['chasles']['compared']['attitude_posyaw_deg']:.2f}", run.inside] for run in runs.values()])
    fast, kitti = runs["MH_03", 1].row, runs["KITTI 00", 2].row
    openvins, orb = kitti["ate_m"]["OpenVINS"], kitti["ate_m"]["ORB-SLAM3"]
    mono, basalt = runs["MH_01", 1].row["ate_m"]["ORB-SLAM3"], fast["ate_m"]["Basalt"]
    head = PEERS_HEAD.format(versions=versions(peers), timed=peers["chasles"], source=peers["source"],
                             conditions=peers["conditions"], measured=state(part["measured"]),
                             basalt=peers["basalt"]["source"],
                             basalt_mono=several(peers["basalt"]["chasles_cpu_ms"][0], ms_text),
                             basalt_stereo=several(peers["basalt"]["chasles_cpu_ms"][1], ms_text),
                             after=max(row["chasles"]["compared"]["from_s"] for row in part["rows"]))
    tail = PEERS_TAIL.format(
        timed=peers["chasles"],
        lost=mono["lost"], lost_of=mono["runs"],
        calibrated=metres(peers["online_calibration"]["OpenVINS"]["m"]),
        tracked=" and ".join(f"{n:.0f}" for n in fast["ate_m"]["ORB-SLAM3"]["tracked"]),
        of_frames=f"{fast['chasles']['frames']:.0f}", start=openvins["start_s"], openvins=metres(openvins["m"]),
        openvins_frames=f"{openvins['frames']:.0f}", openvins_own=metres(openvins["chasles_there_m"]),
        orb=metres(orb["m"]), orb_frames=f"{orb['frames']:.0f}", orb_own=metres(orb["chasles_there_m"]),
        kitti_frames=f"{kitti['chasles']['frames']:.0f}",
        basalt_late=basalt["last_start_s"], basalt_good=f"{basalt['converged']:.0f}",
        basalt_starts=f"{basalt['starts']:.0f}", basalt_fast=several(basalt["m"], metres),
        basalt_kitti=metres(kitti["ate_m"]["Basalt"]["se3_m"]),
        cut=peers["other_cut"], memory=peers["memory_mb"])
    title, text = head.split("\n\n", 1)
    return "\n\n".join([title, wrap(text), comparison(results), own, wrap(tail)]) + "\n"


# ---- docs/results.md and studies/results.md

def compact_table(results: Json) -> str:
    header = ["recording", "landmarks", "dead reckoning m", "Du's filter m", "Chasles m",
              "100 m: dead reckoning %", "Chasles %", "attitude °", "NEES (6)", "× real time"]
    rows = []
    for name, runs in results["stereo_velocity"]["runs"].items():
        default, dead = runs[DEFAULT], runs[DEAD]
        du = [runs[v] for v in ("Du, set 1", "Du, set 2")]
        rows.append([
            short_name(name), cell(default, "landmarks", 0), cell(dead, "ate_m", 2),
            " / ".join(cell(figures, "ate_m", 1) for figures in du),
            cell(default, "ate_m", 2), cell(dead, "rpe_100m_percent", 2),
            cell(default, "rpe_100m_percent", 2), cell(default, "attitude_deg", 2),
            cell(default, "nees_pose", 1), cell(default, "realtime_factor", 0)])
    return padded_table(header, rows)


READING = """**Where the ATE is above dead reckoning.** It is in {above} of the {rows} rows, all of them 2018 or
STARS drives. Their velocities and their truth come from one GNSS/INS, so errors of that system cancel in
dead reckoning. Its ATE there is close to the least possible one, so it is no measure of a filter. The
relative error over 100 m is one: it is below that of dead reckoning in {better} rows that
have it.

**The attitude of {road[attitude_deg]:.2f}°** comes from the alignment. STARS drive 09_26/0027 is a straight
road: over {road[path_m]:.0f} m its positions lie {road[truth_off_line_m]:.2f} m (RMS) off a line, less than
the ATE of {road[ate_m]:.2f} m. The SE(3) alignment uses positions alone, so the rotation about the road is
arbitrary. Dead reckoning has {dead[attitude_deg]:.0f}° for the same reason, and
{dead[attitude_first_pose_deg]:.2f}° with the first poses aligned. `attitude_first_pose_deg` of the summary
is the figure for such a road ([evaluation.md](evaluation.md#2-alignments)).

**Times** are those of {times}. Errors and NEES are those of {errors}."""

STRAIGHT_ROAD = "stars/2011_09_26_drive_0027_sync_KLT"


def reading(results: Json) -> str:
    part = results["stereo_velocity"]
    pairs = {name: (runs[DEFAULT], runs[DEAD]) for name, runs in part["runs"].items()}
    above = [name for name, (own, dead) in pairs.items() if own["ate_m"] > dead["ate_m"]]
    if any(not name.startswith(("ece276a_2018", "stars/2011")) for name in above):
        raise SystemExit(f"studies/front_page.py: above dead reckoning are {above}: change READING")
    long = [(own["rpe_100m_percent"], dead["rpe_100m_percent"]) for own, dead in pairs.values()
            if own["rpe_100m_percent"] is not None]
    road, dead = pairs[STRAIGHT_ROAD]
    if road["truth_off_line_m"] >= road["ate_m"]:
        raise SystemExit("studies/front_page.py: the road is not straight: change READING")
    better = of_all(sum(own < dead for own, dead in long), len(long))
    return wrap(READING.format(above=len(above), rows=len(pairs), better=better, road=road, dead=dead,
                               times=state(part["timed"]), errors=state(part["measured"])))


def of_all(number: int, all_of_them: int) -> str:
    return f"all {number}" if number == all_of_them else f"{number} of the {all_of_them}"


def state(measured: Json) -> str:
    return f"commit {measured['commit']} on {measured['machine']}"


VARIANTS_HEAD = """# Stereo-velocity runs: all variants

This page has every figure of every recording, chart and baseline. `make table` writes it: it runs
`chasles run RECORDING` with the options of each row. [docs/results.md](../docs/results.md) explains
the variants and has the conclusions, and [docs/evaluation.md](../docs/evaluation.md) defines the
figures.

- ATE is given after SE(3) alignment and with the first poses aligned.
- NIS is a mean per degree of freedom, and 1 is consistent. NEES is the mean of the pose, and 6 is
  consistent.
"""


def variants_page(results: Json) -> str:
    part = results["stereo_velocity"]
    page = [VARIANTS_HEAD, wrap(f"Times: {state(part['timed'])}. Other figures: {state(part['measured'])}."), ""]
    header = ["variant", *[heading for heading, _, _ in FIGURES]]
    for name, runs in part["runs"].items():
        page += [f"## {name}", ""]
        rows = [[way, *[cell(figures, key, digits) for _, key, digits in FIGURES]]
                for way, figures in runs.items()]
        page += [padded_table(header, rows), ""]
        for way, figures in runs.items():
            if "error" in figures:
                page += [f"{way}: exit code {figures['exit_code']}, {figures['error']}", ""]
    return "\n".join(page)


# Page, name of its markers, text.
BLOCKS: list[tuple[pathlib.Path, str, typing.Callable[[Json], str]]] = [
    (README, "claim", claim),
    (README, "inertial", lambda results: comparison(results) + "\n\n" + notes(results)),
    (README, "covariance", covariance),
    (README, "loop", loop),
    (README, "limits", limits),
    (STEREO, "results", lambda results: compact_table(results) + "\n\n" + reading(results)),
]


MARKERS = {page: tuple(name for other, name, _ in BLOCKS if other == page) for page in (README, STEREO)}


def fill_pages(results: Json) -> None:
    for page, name, text in BLOCKS:
        fill(page, name, text(results))
    VARIANTS.write_text(variants_page(results))
    PEERS.write_text(peers_page(results))


def main() -> None:
    parser(__doc__).parse_args()
    fill_pages(load())


if __name__ == "__main__":
    main()
