"""studies/recordings_consistency.py on a small simulated recording: a row with figures, a run that fails, and a second
call that makes no run again. Its bands are compared with tables of chi-square."""

import importlib
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent


def study(folder, *more):
    command = [sys.executable, "-m", "studies.recordings_consistency", "--quick", "--only", "^turn", "--recording", f"turntable={folder}/rec", "-o", folder / "out", *more]
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT)


def row_of(folder):
    text = (folder / "out/table.md").read_text()
    rows = [line for line in text.splitlines() if line.startswith("| turntable")]
    assert len(rows) == 1, text
    return [cell.strip() for cell in rows[0].strip("|").split("|")], text


def test_figures(folder):
    done = study(folder)
    assert done.returncode == 0, done.stderr
    assert "1 of 1 runs made now" in done.stdout, done.stdout
    cells, text = row_of(folder)
    assert cells[1] == "`filter`" and cells[-1] in ("ok", "degraded"), cells
    numbers = [float(cell) for cell in cells[2:7]]  # ATE to NEES of the pose
    assert 0 < numbers[0] < 1 and all(n > 0 for n in numbers), cells
    shares = [float(cell) for cell in cells[12:18]]
    assert all(0 <= share <= 100 for share in shares) and float(cells[11]) == min(shares), cells
    assert "| NIS/dof in 0.8 to 1.25 |" in text and " of 1 |" in text, text


def test_resumes(folder):
    before = row_of(folder)[0]
    done = study(folder)
    assert "0 of 1 runs made now" in done.stdout, done.stdout
    assert row_of(folder)[0] == before


def test_failure_is_a_row(folder):
    done = study(folder, "--set", "gate=7")
    assert done.returncode == 0, done.stderr
    cells, text = row_of(folder)
    assert cells[2] == "-" and "exit code 1" in cells[-1] and "gate: found '7'" in cells[-1], cells
    assert "`gate=7`" in text, text


def test_errors(folder):
    for more, message in ((["--only", "no such"], "no recording matches"), (["--only", "("], "no regular expression"),
                          (["--recording", "x"], "expected NAME=PATH")):
        done = study(folder, *more)
        assert done.returncode == 1 and message in done.stderr, done.stderr


def test_bands():
    sys.path.insert(0, str(ROOT))
    module = importlib.import_module("studies.recordings_consistency")
    # 2.5 % and 97.5 % quantiles of chi-square with 30 and 100 degrees of freedom, from tables.
    for dof, count, low, high in ((3, 10, 16.791, 46.979), (1, 100, 74.222, 129.561)):
        band = module.mean_band(dof, count)
        assert abs(band[0] - low / (dof * count)) < 1e-3 and abs(band[1] - high / (dof * count)) < 1e-3, band


def main():
    sys.dont_write_bytecode = True
    test_bands()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        subprocess.run([os.environ["CHASLES_BINARY"], "simulate", "turntable", "-o", folder / "rec", "--quiet", "--set", "revolutions=0.3"], check=True)
        for test in (test_figures, test_resumes, test_failure_is_a_row, test_errors):
            test(folder)


main()
