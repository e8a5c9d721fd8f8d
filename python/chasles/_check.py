"""What a check of a recording finds."""

from __future__ import annotations

import copy
import dataclasses
import html
import json
import os
from typing import Any, Iterator, Optional, Union

from . import _core
from ._progress import bar


@dataclasses.dataclass(frozen=True)
class Finding:
    """A deficiency of a recording."""

    severity: str
    """"note", "warning" (the estimate will be less accurate) or "error" (it will be wrong)."""
    about: str
    """"imu", "images", "cam0", ..."""
    what: str
    """One sentence with the measured value."""
    value: float
    threshold: float
    """The limit beyond which it is a finding."""
    unit: str
    advice: str
    """What to do."""


class Check:
    """The results of a check: findings, measured facts, and what could not be checked."""

    def __init__(self, text: str, report: dict[str, Any]) -> None:
        self._text = text
        self._report = report
        self._findings = tuple(Finding(**one) for one in report["findings"])

    @property
    def report(self) -> dict[str, Any]:
        """What `chasles check --json` prints, as a dictionary of the caller's own."""
        return copy.deepcopy(self._report)

    @property
    def findings(self) -> list[Finding]:
        """In a fixed order."""
        return list(self._findings)

    @property
    def ok(self) -> bool:
        """Whether no finding is an error."""
        return all(finding.severity != "error" for finding in self._findings)

    @property
    def facts(self) -> dict[str, dict[str, dict[str, Any]]]:
        """{about: {name: {"value", "unit"}}}."""
        facts: dict[str, dict[str, dict[str, Any]]] = self.report["facts"]
        return facts

    @property
    def not_checked(self) -> list[str]:
        """One sentence for each check that was not possible."""
        sentences: list[str] = self.report["not_checked"]
        return sentences

    def __iter__(self) -> Iterator[Finding]:
        return iter(self._findings)

    def __len__(self) -> int:
        return len(self._findings)

    def __bool__(self) -> bool:
        return True  # not whether there are findings: `check.ok` says that

    def __str__(self) -> str:
        return self._text

    def __repr__(self) -> str:
        return f"<chasles.Check of '{self._report['name']}': {len(self._findings)} findings{'' if self.ok else ', with errors'}>"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(self._text)}</pre>"


def check(recording: Union[_core.Recording, _core.Path], *, seconds: float = 20, calibration: bool = False,
          progress: Optional[bool] = None) -> Check:
    """Checks clocks, gaps, exposure, units and calibration of a recording (Recording, or a path), as `chasles check`
    does, and returns a Check: `print(check)` is the report, `check.findings` a list. seconds: length of the images that
    are tracked, those with the most rotation. calibration: compare lenses, mounting and clock with what batch estimation
    of the whole recording finds, in sigmas, as --calibration does; needs about as long as the recording. progress: a
    bar, as in `run`."""
    if not isinstance(recording, _core.Recording):
        recording = _core.read(os.fspath(recording))
    with bar(progress, "check", "frames", "trial") as advance:
        report, text = _core.check(recording, seconds, bool(calibration), advance)
    return Check(text, json.loads(report))
