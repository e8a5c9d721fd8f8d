"""The arrays for learning of docs/exports.md as a table of `datasets`, in which LeRobot keeps an episode."""

import pathlib
import re

import numpy as np

PAGE = pathlib.Path(__file__).resolve().parents[3] / "docs/exports.md"


def test_an_episode_is_a_table_of_datasets(tmp_path):
    import datasets
    names = {}
    block, = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    exec(compile(block, str(PAGE), "exec"), names)
    episode, rows, times, run = (names[name] for name in ("episode", "rows", "times", "run"))
    number = datasets.Value("float32")
    features = datasets.Features({
        "observation.state": datasets.List(number, length=7), "observation.covariance": datasets.List(number, length=36),
        "observation.known": datasets.Value("bool"), "timestamp": number, "frame_index": datasets.Value("int64")})
    file = tmp_path / "episode_000000.parquet"
    datasets.Dataset.from_dict(episode, features=features).to_parquet(str(file))
    table = datasets.Dataset.from_parquet(str(file), cache_dir=str(tmp_path / "cache")).with_format("numpy")
    assert len(table) == len(times) > 100
    state = np.asarray(table["observation.state"])
    assert np.allclose(state[:, :3], rows["position"], atol=1e-5) and np.isfinite(state).all()
    assert np.allclose(np.diff(table["timestamp"]), 1 / 30, atol=1e-5)
    assert np.asarray(table["observation.known"]).all()
    # At the first and the last time, the neighbours' own numbers are near.
    states = run.states
    assert np.allclose(state[0, :3], states["position"][0], atol=1e-6)
    covariance = np.asarray(table["observation.covariance"]).reshape(-1, 6, 6)
    assert np.allclose(covariance[-1], states["pose_covariance"][-2:].max(axis=0), rtol=0.3, atol=1e-4)
