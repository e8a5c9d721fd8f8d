"""The types that the package states are those that it has."""

import ast
import os
import pathlib
import re
import shutil
import subprocess
import sys
import textwrap

import pytest

import chasles

PACKAGE = pathlib.Path(chasles.__file__).parent


@pytest.fixture
def alone(tmp_path):
    """A folder with the package alone: what else is installed beside it is none of mypy's sources."""
    (tmp_path / "alone").mkdir()
    (tmp_path / "alone/chasles").symlink_to(PACKAGE)
    return tmp_path / "alone"


def checked(folder, *command):
    environment = {**os.environ, "MYPYPATH": str(folder), "PYTHONPATH": str(folder)}
    done = subprocess.run(command, capture_output=True, text=True, timeout=200, env=environment)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.skipif(not shutil.which("mypy"), reason="mypy is not installed")
def test_the_package_agrees_with_its_types(alone, tmp_path):
    # What the package itself exports; chasles.interop passes objects of packages without types on.
    files = [alone / "chasles" / name for name in (
        "__init__.py", "_arguments.py", "_arrays.py", "_batch.py", "_calibrate.py", "_calibrate_imu.py", "_calls.pyi", "_check.py", "_core.pyi", "_executors.py",
        "_functions.py", "_lab.pyi", "_laboratory.py", "_optional.py", "_page.py", "_picture.py", "_places.py", "_plot.py",
        "_progress.py", "_run.py", "_settings.py", "_views.py", "lab.py")]
    checked(alone, "mypy", "--strict", "--ignore-missing-imports", "--follow-imports", "silent", "--cache-dir", tmp_path,
            *files)


@pytest.mark.skipif(not shutil.which("stubtest"), reason="mypy is not installed")
def test_the_module_agrees_with_its_stubs(alone, tmp_path):
    allowed = tmp_path / "allowed"
    # Classes of pybind11 have a metaclass of its own; their members are compared one by one. mypy 1.0 takes a
    # cached_property of the sources for another one at run time. The rest is for types alone, or added by Python.
    allowed.write_text("""
chasles(\\._core|\\.lab)?\\.(Camera|CaptureGuide|ChartState|Estimate|FirstSight|ImuNoise|PredictedState|RealtimeSlam|Recording|Run|Slam|Target)
chasles(\\._functions|\\._run|\\._calls|\\._batch)?\\.Run\\.(_columns|_summary)
chasles(\\._settings)?\\.\\w+(Settings|Arguments)
chasles\\._core\\.(Path|Time|Floats|Ints|Image|_.*)
chasles\\._lab\\._.*
.*\\.(Any|Callable|Iterable|Iterator|Mapping|NamedTuple|Sequence|NoReturn|Recording|Run|TYPE_CHECKING)
.*\\.__(init|new|setstate|getstate|repr|hash)__
""")
    config = tmp_path / "mypy.ini"
    config.write_text("[mypy]\nignore_missing_imports = True\n")
    checked(alone, "stubtest", "chasles", "--mypy-config-file", config, "--ignore-missing-stub",
            "--ignore-unused-allowlist", "--allowlist", allowed)


ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def examples_of(page):
    return re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)


@pytest.mark.skipif(not shutil.which("mypy"), reason="mypy is not installed")
def test_the_examples_of_the_pages_have_right_types(alone, tmp_path):
    files = []
    for page in PAGES:
        blocks = examples_of(page)
        if not blocks:
            continue
        text = "\n".join(blocks)
        if "import chasles\n" not in text:
            text = "import chasles\n" + text
        files.append(tmp_path / f"{page.stem.lower()}_example.py")
        files[-1].write_text(text)
    assert {file.stem for file in files} >= {"python_example", "interoperation_example", "readme_example"}
    checked(alone, "mypy", "--strict", "--ignore-missing-imports", "--follow-imports", "silent", "--cache-dir",
            tmp_path / "cache", *files)


@pytest.mark.skipif(not shutil.which("mypy"), reason="mypy is not installed")
@pytest.mark.parametrize("line", [
    "chasles.run(recording, max_landmark=30)",
    "chasles.run(recording, estimater='batch')",
    "chasles.run(recording, chart=3)",
    "chasles.run(recording, start={'headin': 0})",
    "chasles.simulate('hallway', hall_lenght=3)",
    "chasles.monte_carlo('hallway', {'a': {'chrat': 'standard'}}, runs=1)",
    "chasles.monte_carlo('hallway', {'a': {}}, runs=1, hall_lenght=3)",
    "chasles.compare(recording, {'a': {'estimater': 'batch'}})",
    "chasles.Slam(recording.cameras, recording.imu_noise or noise, max_landmark=3)",
    "chasles.RealtimeSlam(recording.cameras, recording.imu_noise or noise, most_image=3)",
    "chasles.read('a', strat=1)",
    "chasles.check('a').finding",
])
def test_a_misspelt_key_is_an_error_of_mypy(alone, tmp_path, tmp_path_factory, line):
    right = tmp_path / "right.py"
    right.write_text(textwrap.dedent("""
        import chasles
        settings: chasles.RunSettings = {"max_landmarks": 30, "start": {"heading": 0.0}}
        recording = chasles.read("a", start=1)
        noise = chasles.ImuNoise(accelerometer_noise_density=1, gyroscope_noise_density=1, accelerometer_random_walk=1,
                                 gyroscope_random_walk=1)
        chasles.run(recording, estimator="batch", **settings)
        chasles.compare(recording, {"a": {"estimator": "batch", "start": {"heading": 0}}}, threads=1)
        chasles.Slam(recording.cameras, noise, max_landmarks=3)
        chasles.run(recording, pixel_sigma="auto")
        chasles.Slam(recording.cameras[0], noise, map=None)
    """))
    command = ("mypy", "--strict", "--ignore-missing-imports", "--follow-imports", "silent", "--cache-dir",
               tmp_path_factory.getbasetemp() / "mypy")
    checked(alone, *command, right)
    wrong = tmp_path / "wrong.py"
    wrong.write_text(right.read_text() + line + "\n")
    environment = {**os.environ, "MYPYPATH": str(alone), "PYTHONPATH": str(alone)}
    done = subprocess.run([*command, wrong], capture_output=True, text=True, timeout=200, env=environment)
    assert done.returncode == 1 and f"wrong.py:{len(wrong.read_text().splitlines())}: error" in done.stdout, done.stdout


def test_the_stub_has_docstrings():
    tree = ast.parse((PACKAGE / "_core.pyi").read_text(encoding="utf-8"))
    for one in tree.body:
        if not isinstance(one, ast.ClassDef) or one.name.endswith("Error") or one.name == "Run":
            continue
        assert ast.get_docstring(one), one.name
        for member in one.body:
            if isinstance(member, ast.FunctionDef) and not member.name.startswith("_"):
                assert ast.get_docstring(member), f"{one.name}.{member.name}"
    calls = ast.parse((PACKAGE / "_calls.pyi").read_text(encoding="utf-8"))
    assert all(ast.get_docstring(one) for one in calls.body if isinstance(one, ast.FunctionDef))


def test_the_types_are_those_of_the_settings():
    """Of this module: tools/python-types writes them anew."""
    environment = {**os.environ, "PYTHONPATH": str(PACKAGE.parent)}
    done = subprocess.run([sys.executable, ROOT / "python/types/write.py", "--check"], capture_output=True, text=True,
                          timeout=60, env=environment)
    assert done.returncode == 0, done.stdout + done.stderr
