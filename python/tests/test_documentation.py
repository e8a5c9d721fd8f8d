"""The examples of docs/python.md run as they stand, one after the other."""

import pathlib
import re

import numpy

import chasles

PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs/python.md"


def test_the_examples_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert len(blocks) >= 2
    names = {}
    for block in blocks:
        exec(compile(block, str(PAGE), "exec"), names)
    assert (tmp_path / "walk/trajectory.tum").exists() and (tmp_path / "walk.html").exists()
    out = capsys.readouterr().out
    assert "\nTrue  " in out and "Average NEES" in out


def test_the_estimates_step_by_step_are_those_of_the_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    block = re.search(r"## Step by step.*?```python\n(.*?)```", PAGE.read_text(), re.DOTALL).group(1)
    names = {"chasles": chasles}
    exec(compile(block, str(PAGE), "exec"), names)
    states = chasles.run(names["recording"], max_landmarks=30).states
    estimates = names["estimates"]
    assert [e.time for e in estimates] == list(states["time"])
    assert (numpy.array([e.position for e in estimates]) == states["position"]).all()
    assert (numpy.array([e.pose_covariance for e in estimates]) == states["pose_covariance"]).all()
    assert len(capsys.readouterr().out.splitlines()) == len(estimates) + 2
