#!/usr/bin/env python3
"""python3 -m studies.cases [--before PROGRAM] [--part PART] [--jobs N] [--limit SECONDS] [NAME...]: inputs that people have,
before and after. It makes the inputs, runs `chasles run`, `chasles check` or `chasles evaluate` on them, and
compares their outcome with what is right. There are two parts:

recordings  faults put into a rendered walk and EuRoC's MH_01 (../shared/cases): studies/cases.md
reports     inputs re-made from public reports (../shared/cases/reports), 6 s of MH_01: studies/reports.md

PROGRAM (or $CHASLES_BEFORE) is an older chasles: it fills the columns "before". Without it there are none. The
program of the columns "after" is $CHASLES_BINARY, or that of build/release. A command that takes longer than
SECONDS (120) is ended. $CHASLES_CASES replaces ../shared/cases, and $CHASLES_DATA ../shared/data.

The script fills the pages and writes out/cases/results.json and out/cases/reports.json with all commands and
their output. With names (substrings of "walk/every_second_image_torn" or "reports/folders/imu_seconds") it runs
only those cases, and only prints. Outcomes of the reports are kept in out/cases/cache, for each program, generator
and case: only what is new runs. Several of these scripts may run at once."""

import argparse
import os
import pathlib
import shutil
import tempfile

from studies import cases_recordings
from studies import cases_run
from studies import reports

PARTS = {"recordings": cases_recordings.main, "reports": reports.main}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--before", default=os.environ.get("CHASLES_BEFORE"), metavar="PROGRAM")
    parser.add_argument("--part", choices=PARTS)
    parser.add_argument("--jobs", type=int, default=2, metavar="N")
    parser.add_argument("--limit", type=float, default=120, metavar="SECONDS")
    parser.add_argument("--cache", type=pathlib.Path, default=cases_run.OUT / "cache", metavar="FOLDER",
                        help="outcomes of the reports (out/cases/cache)")
    options = parser.parse_args()
    programs = {**({"before": options.before} if options.before else {}), "after": cases_run.CHASLES}
    cases_run.OUT.mkdir(parents=True, exist_ok=True)
    work = pathlib.Path(tempfile.mkdtemp(prefix="work-", dir=cases_run.OUT))
    try:
        programs = {which: pathlib.Path(shutil.copy(program, work / which)) for which, program in programs.items()}  # a build may go on
        wrong = [line for part, run in PARTS.items() if options.part in (None, part) for line in run(options, programs, work)]
    finally:
        shutil.rmtree(work, ignore_errors=True)
    print("not right:", *wrong, sep="\n  ") if wrong else print("all are right")


if __name__ == "__main__":
    main()
