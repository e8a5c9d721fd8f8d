"""What the tests of the conversions in python/examples share."""

import csv
import os
import pathlib
import subprocess
import sys

BINARY = os.environ.get("CHASLES_BINARY")
_EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples"


def chasles(*arguments):
    ended = subprocess.run([BINARY, *map(str, arguments)], capture_output=True, text=True, timeout=300)
    assert ended.returncode == 0, ended.stderr
    return ended.stdout


def run_example(name, *arguments):
    command = [sys.executable, _EXAMPLES / name, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=300)


def table(file):
    with open(file) as lines:
        return list(csv.reader(lines))[1:]
