"""The examples of docs/python.md run as they stand, one after the other."""

import pathlib
import re

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
