"""python3 -m studies.against OLD: what a run costs over what it costs with another build of the program.

Runs both programs in turns, on one thread, and prints the ratio of this build (CHASLES_BINARY) to OLD: processor time
of the estimator and front end, that of the whole run, and the largest memory, each the median of the rounds with the
lowest and the highest ratio of a round. Errors are those of the last round of each. Recordings of cases that are
simulated are kept in out/against."""

import dataclasses
import os
import pathlib
import statistics
import subprocess
import tempfile
import typing

from . import program
from .program import ROOT

FOLDER = ROOT / "out/against"
MH_01 = program.EUROC / "MH_01_easy_17s"


@dataclasses.dataclass(frozen=True)
class Case:
    """A run: of a recording that is there, or of a simulated one."""

    what: str
    recording: pathlib.Path
    arguments: tuple[str, ...] = ()
    simulated: tuple[str, ...] = ()

    def prepare(self) -> None:
        if self.simulated and not self.recording.exists():
            program.chasles("simulate", *self.simulated, "--quiet", "-o", self.recording)


WALK = FOLDER / "walk"
HOUR = FOLDER / "hour"
CASES = {
    "mono": Case("MH_01, one camera", MH_01, ("--cameras", "0")),
    "stereo": Case("MH_01, two cameras", MH_01),
    "kitti": Case("KITTI 00, two cameras", program.DATA / "kitti_images/00_first_13s"),
    "window": Case("MH_01, one camera, window:20", MH_01, ("--cameras", "0", "--estimator", "window:20")),
    "batch": Case("MH_03, one camera, batch", program.EUROC / "MH_03_medium_27s_mono", ("--estimator", "batch")),
    "recognition": Case("walk of 1 km by tracks, recognition", FOLDER / "kilometre", ("--set", "recognise=ids"),
                        ("walk", "--set", "sections=50")),
    "images": Case("rendered walk of 247 s", WALK, (), ("walk", "--images")),
    "hour": Case("hallway of 69 minutes by tracks", HOUR, (), ("hallway", "--set", "sections=240")),
}


@dataclasses.dataclass(frozen=True)
class Cost:
    step: float  # of front end and estimator [ms a frame]
    whole: float  # processor time, reading and writing included [s]
    memory: float  # largest [MB]
    ate: float  # [m]
    nees: float  # of the pose


def cost(binary: pathlib.Path, case: Case) -> Cost:
    with tempfile.TemporaryDirectory(prefix="chasles-against-") as folder:
        run = pathlib.Path(folder) / "run"
        command = [binary, "run", case.recording, "--threads", "1", "--quiet", "-o", run, *case.arguments]
        child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        assert child.stderr is not None
        fault = child.stderr.read()
        _, status, usage = os.wait4(child.pid, 0)
        code = child.returncode = os.waitstatus_to_exitcode(status)
        if code != 0:
            raise program.Failed(f"studies: {binary} run {case.recording} ended with {code}: {fault.strip()}")
        timing = program.read_json(run / "timing.json")
        errors = program.read_json(run / "summary.json")
    return Cost(step=timing.get("frontend_ms_per_frame", 0) + timing["filter_ms_per_frame"],
                whole=usage.ru_utime + usage.ru_stime, memory=usage.ru_maxrss / 1024,
                ate=errors.get("ate_posyaw_m", float("nan")), nees=errors.get("nees_pose", float("nan")))


def ratios(old: typing.Sequence[Cost], new: typing.Sequence[Cost], of: str) -> str:
    """Of medians, and those of each round."""
    before, after = [getattr(one, of) for one in old], [getattr(one, of) for one in new]
    each = sorted(b / a for a, b in zip(before, after))
    return (f"{statistics.median(before):9.3g} {statistics.median(after):9.3g} "
            f"{statistics.median(after) / statistics.median(before):6.2f} ({each[0]:.2f} to {each[-1]:.2f})")


FIGURES = {"step": "front end, estimator [ms]", "whole": "processor time [s]", "memory": "memory [MB]"}


def main() -> None:
    parser = program.parser(__doc__)
    parser.add_argument("old", type=pathlib.Path, help="the program of the other build")
    parser.add_argument("cases", nargs="*", type=program.one_of(CASES), metavar="CASE",
                        help=f"of {', '.join(CASES)}; all if none is named")
    parser.add_argument("--rounds", type=program.count, default=5)
    arguments = parser.parse_args()
    rounds = max(1, arguments.rounds)
    for name in arguments.cases or CASES:
        case = CASES[name]
        case.prepare()
        old, new = [], []
        for _ in range(rounds):
            old.append(cost(arguments.old, case))
            new.append(cost(program.CHASLES, case))
        print(f"{name}: {case.what}\n{'':30}{'old':>9} {'new':>9}  ratio")
        for of, unit in FIGURES.items():
            print(f"  {unit:<26}  {ratios(old, new, of)}")
        print(f"  {'ATE [m]':<26}  {old[-1].ate:9.3g} {new[-1].ate:9.3g}")
        print(f"  {'NEES of the pose / 6':<26}  {old[-1].nees / 6:9.3g} {new[-1].nees / 6:9.3g}", flush=True)


if __name__ == "__main__":
    main()
