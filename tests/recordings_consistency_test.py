"""studies/recordings_consistency.py on a small simulated recording: rows with figures, a run that fails, and a second
call that makes no run again. Its figures, means and goals are compared with known input."""

import importlib
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
sys.dont_write_bytecode = True


def study(folder, *more):
    command = [sys.executable, "-m", "studies.recordings_consistency", "--quick", "--draws", "2", "--only", "^turn",
               "--recording", f"turntable={folder}/rec", "-o", folder / "out", *more]
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT)


def rows_of(folder, count):
    """The rows of the table, each by the names of its columns."""
    text = (folder / "out/table.md").read_text()
    lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines()]
    header = next(line for line in lines if line[0] == "recording")
    rows = [dict(zip(header, line)) for line in lines if line[0] == "turntable"]
    assert len(rows) == count and all(len(row) == len(header) for row in rows), text
    return rows, text


def pair(cell):
    mean, spread = cell.split(" ± ")
    return float(mean), float(spread)


def test_figures(folder):
    done = study(folder)
    assert done.returncode == 0, done.stderr
    assert "2 of 2 runs made now" in done.stdout, done.stdout
    (path, smoothed), text = rows_of(folder, 2)
    assert (path["path"], smoothed["path"]) == ("`filter`", "smoothed path"), text
    for row in (path, smoothed):
        assert row["state"].split()[-1] in ("ok", "degraded"), row
        assert 0 < pair(row["ATE m"])[0] < 1 and pair(row["pose"])[0] > 0, row
        assert 0 <= pair(row["least within 3σ %"])[0] <= 100, row
    # Draws are other parts of the tracks.
    assert pair(path["pose"])[1] > 0 and path["pose"] != smoothed["pose"], text
    assert pair(path["NIS/dof"])[0] > 0 and smoothed["NIS/dof"] == "-", text
    if (ROOT / "build/studies-venv/bin/python").exists():
        for row in (path, smoothed):
            assert pair(row["k"])[0] > 0 and 0 <= pair(row["90 % coverage"])[0] <= 100, row
            assert 0 < pair(row["CRPS mm"])[0] < 1e3 * pair(row["ATE m"])[0] + 100, row
            assert 0.5 < pair(row["scale"])[0] < 2, row
    else:
        assert path["k"] == "-" and "without scores" in done.stderr, done.stderr
    assert "| NIS/dof in 0.8 to 1.25 |" in text and " of 1 |" in text, text


def test_resumes(folder):
    before = rows_of(folder, 2)[0]
    done = study(folder)
    assert "0 of 2 runs made now" in done.stdout, done.stdout
    assert rows_of(folder, 2)[0] == before


def test_failure_is_a_row(folder):
    done = study(folder, "--set", "gate=7")
    assert done.returncode == 0, done.stderr
    (row,), text = rows_of(folder, 1)
    assert row["ATE m"] == "-" and row["state"].startswith("exit code 1"), row
    assert "gate: found '7'" in row["state"] and "`gate=7`" in text, text


def test_errors(folder):
    for more, code, message in ((["--only", "no such"], 1, "no recording matches"),
                                (["--only", "("], 1, "no regular expression"),
                                (["--recording", "x"], 1, "expected NAME=PATH"),
                                (["--draws", "0"], 2, "--draws: found 0, expected 1 or more")):
        done = study(folder, *more)
        assert done.returncode == code and message in done.stderr, done.stderr


def result(pose, scale=1.0, health="ok"):
    """Of a run, in the form of summary.json and of `chasles evaluate --truth-errors auto --json`."""
    shares = {f"within_3_sigma_{axis}": 1 for axis in ("rx", "ry", "rz", "x", "y")} | {"within_3_sigma_z": 0.5}
    known = {"truth_errors": {"nees_pose": {"mean": 9.0, "median": 5, "dof": 6}}}
    path = {"ate_posyaw_m": 0.1, "nees_pose": pose, "nees_position": 3, "nees_attitude": None, "health": health,
            "frames": 100, "seconds_cpu": 2, "nis_per_dof": 1.1, "scale_sigma": 0.01, **shares,
            "scores": {"k": 1.5, "coverage": 0.85, "crps": 0.004, "scale": scale}, "known": known}
    return {"path": path, "smoothed": {"nees_pose": 2 * pose}}


def test_figures_of_known_results():
    study = importlib.import_module("studies.recordings_consistency")
    path, smoothed = (study.figures_of(result(12), smoothed=s) for s in (False, True))
    assert (path["pose"], path["position"], path["attitude"]) == (2, 1, None), path
    assert (path["known"], path["least"], path["ms"], path["scale_sigma"]) == (1.5, 0.5, 20, 0.01), path
    assert (path["k"], path["coverage"], path["crps"], path["scale"]) == (1.5, 0.85, 0.004, 1), path
    assert (smoothed["pose"], smoothed["known"], smoothed["ms"], smoothed["state"]) == (4, None, 20, "ok"), smoothed
    # Nothing is left of the errors after the truth's are fitted.
    nothing = result(12)
    nothing["path"]["known"]["truth_errors"]["nees_pose"]["mean"] = None
    assert study.figures_of(nothing)["known"] is None
    assert study.figures_of({"problem": "out of time"})["state"] == "out of time"


def test_rows_and_goals():
    study = importlib.import_module("studies.recordings_consistency")
    near = study.Row("near", "filter", [result(6, 0.995), result(18, 0.975, "degraded"), result(12, 0.985)])
    far = study.Row("far", "batch", [result(60, 1.03), {"problem": "a | b"}])
    cells = dict(zip(["title", "path", *(c[0] for c in study.COLUMNS), "state"], near.cells()))
    assert cells["pose"] == "2.00 ± 1.00" and cells["scale"] == "0.985 ± 0.010", cells
    assert cells["90 % coverage"] == "85 ± 0" and cells["attitude"] == "-" and cells["state"] == "2 ok, 1 degraded"
    assert far.cells()[2] == "0.100" and far.cells()[-1] == "1 ok, 1 a \\| b", far.cells()
    goals = [line for line in study.goals([near, far]).splitlines() if "NEES/dof of the pose" in line or "scale" in line]
    assert goals[0].endswith("| 1 of 2 | far `batch` |") and goals[1].endswith("| 2 of 2 | - |"), goals
    assert goals[2].endswith("| 1 of 2 | far `batch` |"), goals


def test_draws():
    runs = importlib.import_module("studies.consistency_runs")
    study = importlib.import_module("studies.recordings_consistency")
    real = runs.Recording("real", ROOT / "studies/bands.py")
    demo = runs.Recording("demo", render=["walk"])
    seeded = runs.Recording("walk", render=["walk"], seeded=True)
    assert real.options(3) == ["--tracks", "0.8", "--tracks-seed", "3"] and real.rendering(3) is None
    assert demo.options(3) == real.options(3) and demo.rendering(3) == ["walk"]
    assert seeded.options(3) == [] and seeded.rendering(3) == ["walk", "--seed", "3"]
    with tempfile.TemporaryDirectory() as name:
        plan = study.Plan(runs.Store(pathlib.Path(name), 1), [real, demo, seeded], ("filter", "batch"), ["a=1"], 4)
        # Runs of one rendering go one after the other.
        assert sorted(len(job) for job in plan.jobs()) == [2] * 8 + [8], plan.jobs()
        assert all(run.options[-2:] == ["--set", "a=1"] for run in plan.runs)
        assert len({plan.store.key(r.recording, r.draw, r.options) for r in plan.runs}) == len(plan.runs) == 24


def main():
    for test in (test_figures_of_known_results, test_rows_and_goals, test_draws):
        test()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        subprocess.run([os.environ["CHASLES_BINARY"], "simulate", "turntable", "-o", folder / "rec", "--quiet", "--set", "revolutions=0.3"], check=True)
        for test in (test_figures, test_resumes, test_failure_is_a_row, test_errors):
            test(folder)


main()
