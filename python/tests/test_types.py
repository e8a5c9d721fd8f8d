"""The types that the package states are those that it has."""

import os
import pathlib
import shutil
import subprocess

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
    files = [alone / "chasles" / name for name in ("__init__.py", "lab.py", "_page.py", "_core.pyi")]
    checked(alone, "mypy", "--strict", "--ignore-missing-imports", "--follow-imports", "silent", "--cache-dir", tmp_path,
            *files)


@pytest.mark.skipif(not shutil.which("stubtest"), reason="mypy is not installed")
def test_the_module_agrees_with_its_stubs(alone, tmp_path):
    allowed = tmp_path / "allowed"
    # Classes of pybind11 have a metaclass of its own; their members are compared one by one. mypy 1.0 takes a
    # cached_property of the sources for another one at run time. The rest is for types alone, or added by Python.
    allowed.write_text("""
chasles(\\._core|\\.lab)?\\.(Camera|ChartState|Estimate|FirstSight|ImuNoise|PredictedState|RealtimeSlam|Recording|Run|Slam)
chasles\\.Run\\.(in_map|landmarks|smoothed|states|summary|truth)
chasles\\._core\\.(Path|Time|Floats|Ints|Image|_.*)
.*\\.(Any|Callable|Mapping|NoReturn|Recording|Run|TYPE_CHECKING)
.*\\.__(init|new|setstate|getstate|repr|hash)__
""")
    config = tmp_path / "mypy.ini"
    config.write_text("[mypy]\nignore_missing_imports = True\n")
    checked(alone, "stubtest", "chasles", "--mypy-config-file", config, "--ignore-missing-stub",
            "--ignore-unused-allowlist", "--allowlist", allowed)
