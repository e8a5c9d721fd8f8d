"""The examples of docs/python.md run as they stand, one after the other."""

import importlib.util
import pathlib
import re

import numpy

import chasles

PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs/python.md"
SMALL = ["image_width=320", "image_height=240", "focal_length=180", "center_u=160", "center_v=120", "frame_rate=10",
         "sections=1", "hall_length=8"]


def test_the_examples_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    sets = [word for one in SMALL for word in ("--set", one)]
    assert chasles.command("simulate", "hallway", "--images", *sets, "-o", "MH_01_easy", "--quiet") == 0
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert len(blocks) >= 5
    names = {}
    for block in blocks:
        if importlib.util.find_spec("matplotlib") is None:
            block = re.sub(r"^run\.plot\(\).*$", "", block, flags=re.MULTILINE)
        exec(compile(block, str(PAGE), "exec"), names)
    assert (tmp_path / "walk/trajectory.tum").exists() and (tmp_path / "walk.html").exists()
    assert (tmp_path / "run.png").exists() == (importlib.util.find_spec("matplotlib") is not None)
    out = capsys.readouterr().out
    assert "\nTrue  " in out and "Average NEES" in out and "findings" in out
    assert isinstance(names["run"], chasles.Run)


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


def test_the_example_of_gtsam_has_a_problem():
    """Without gtsam up to where it is needed."""
    page = PAGE.with_name("interoperation.md")
    block = re.search(r"## gtsam.*?```python\n(.*?)```", page.read_text(), re.DOTALL).group(1)
    if importlib.util.find_spec("gtsam") is None:
        assert "graph, values = gtsam_graph(run)" in block
        block = re.sub(r"^graph, values = .*$", "", block, flags=re.MULTILINE)
    names = {"chasles": chasles}
    exec(compile(block, str(page), "exec"), names)
    assert len(names["run"].states["time"]) > 50 and names["batch_problem"](names["run"])["cost"] > 0


def test_the_table_of_estimators_has_the_figures_of_the_demo():
    """The filter's row is what `make demo` prints, on the same page."""
    text = PAGE.with_name("start.md").read_text()
    printed = [re.search(rf"{name} +(\d+\.\d+)", text).group(1) for name in (r"ATE, SE\(3\)-aligned", "NEES of the pose")]
    row = re.search(r"\| filter \| (\S+) \| (\S+) \|", text)
    assert [row[1], row[2]] == printed
