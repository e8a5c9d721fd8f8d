"""The types that the package states are those that it has."""

import os
import pathlib
import shutil
import subprocess

import pytest

import chasles

PACKAGE = pathlib.Path(chasles.__file__).parent


def checked(*command):
    environment = {**os.environ, "MYPYPATH": str(PACKAGE.parent), "PYTHONPATH": str(PACKAGE.parent)}
    done = subprocess.run(command, capture_output=True, text=True, timeout=200, env=environment)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.skipif(not shutil.which("mypy"), reason="mypy is not installed")
def test_the_package_agrees_with_its_types(tmp_path):
    checked("mypy", "--strict", "--ignore-missing-imports", "--cache-dir", tmp_path, PACKAGE)


@pytest.mark.skipif(not shutil.which("stubtest"), reason="mypy is not installed")
def test_the_module_agrees_with_its_stubs(tmp_path):
    allowed = tmp_path / "allowed"
    # Names for the stubs alone, and what pybind11 adds.
    allowed.write_text("chasles._core.(Path|Time|Floats|Ints|Image)\n.*__(init|new|setstate|getstate|repr|hash)__\n")
    checked("stubtest", "chasles", "--ignore-missing-stub", "--ignore-unused-allowlist", "--allowlist", allowed)
