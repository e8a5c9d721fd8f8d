"""Where the repository, the program and the recordings are, and how a study runs the program and reads its files."""

import argparse
import json
import os
import pathlib
import subprocess
import typing

ROOT = pathlib.Path(__file__).resolve().parent.parent
CHASLES = pathlib.Path(os.environ.get("CHASLES_BINARY", ROOT / "build/release/bin/chasles"))
DATA = pathlib.Path(os.environ.get("CHASLES_DATA", ROOT / "../shared/data"))
EUROC = DATA / "euroc"
CONFIGS = ROOT / "studies/configs"
LOST = 4  # exit code of a run whose estimate was lost, which is a result in some studies

Argument = str | float | pathlib.Path
Arguments = typing.Sequence[Argument]
Json = dict[str, typing.Any]


class Failed(SystemExit):
    """The program ended with an exit code that the study does not accept."""


def chasles(*arguments: Argument, accepted: typing.Container[int] | None = (0,), silent: bool = False,
            timeout: float | None = None) -> "subprocess.CompletedProcess[str]":
    """Runs the program and keeps its standard output; `silent`: its standard error too. `accepted`: the exit codes
    with which the study goes on, None for all."""
    command = [str(a) for a in (CHASLES, *arguments)]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE if silent else None, text=True,
                          cwd=ROOT, timeout=timeout)
    if accepted is not None and done.returncode not in accepted:
        why = f": {done.stderr.strip()}" if silent else ""
        raise Failed(f"studies: chasles {' '.join(command[1:])} ended with {done.returncode}{why}")
    return done


def sets(*settings: str, option: str = "--set") -> list[str]:
    """KEY=VALUE of each setting as arguments."""
    return [part for setting in settings for part in (option, setting)]


def scene_sets(*settings: str) -> list[str]:
    return sets(*settings, option="--scene-set")


def assignments(values: typing.Mapping[str, object]) -> list[str]:
    return [f"{key}={value}" for key, value in values.items()]


def render(folder: pathlib.Path, scene: str, settings: typing.Mapping[str, object], *more: Argument) -> None:
    """Renders a recording of a scene, unless its folder is there."""
    if not folder.exists():
        chasles("simulate", scene, *more, *sets(*assignments(settings)), "--images", "--threads", 1, "--quiet", "-o",
                folder)


def read_json(file: pathlib.Path) -> typing.Any:
    return json.loads(file.read_text())


def read_json_lines(file: pathlib.Path) -> list[Json]:
    return [json.loads(line) for line in file.read_text().splitlines()]


def parser(description: str | None) -> argparse.ArgumentParser:
    """The arguments of a study, whose docstring begins with its command."""
    command = " ".join((description or "").split(":")[0].split()[:3])
    return argparse.ArgumentParser(prog=command, description=description,
                                   formatter_class=argparse.RawDescriptionHelpFormatter)


def count(text: str) -> int:
    """A number of runs or draws from the command line."""
    value = int(text)
    if value < 0:
        raise ValueError(text)
    return value


def one_of(names: typing.Iterable[str]) -> typing.Callable[[str], str]:
    """For positional arguments of any number, whose `choices` would reject that there are none."""
    known = list(names)

    def checked(text: str) -> str:
        if text not in known:
            raise argparse.ArgumentTypeError(f"found '{text}', expected one of {', '.join(known)}")
        return text

    return checked
