"""Where figures come from: program and machine, for studies/results.json."""

import os
import pathlib
import platform
import subprocess
import typing


def machine() -> str:
    model = next((line.split(":", 1)[1].strip()
                  for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines()
                  if line.startswith("model name")), platform.processor())
    return f"{os.cpu_count()} cores, {model}, {platform.platform(terse=True)}; one thread used"


def measured(program: pathlib.Path) -> dict[str, str]:
    """The program's version, the commit of the tree that it lies in, and this machine."""
    version = subprocess.run([program, "--version"], capture_output=True, text=True, check=True).stdout.split()[-1]
    commit = subprocess.run(["git", "-C", program.parent, "rev-parse", "--short=8", "HEAD"], capture_output=True,
                            text=True).stdout.strip()
    return {"version": version, "commit": commit or "unknown", "machine": machine()}


def rounded(value: typing.Any) -> typing.Any:
    """To six digits, as the results keep it."""
    return float(f"{value:.6g}") if isinstance(value, float) else value
