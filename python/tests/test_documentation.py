"""The examples of docs/python.md run as they stand, one after the other."""

import importlib.util
import pathlib
import re

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
