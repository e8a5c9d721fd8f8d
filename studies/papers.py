#!/usr/bin/env python3
"""python3 -m studies.papers du | kleinert-stilla: the experiments of a founding paper. It draws the paper's
figures and prints its tables on one page, out/papers/NAME/page.html. It fills docs/papers.md and
studies/papers.md between their markers and draws the pictures. Needs numpy and matplotlib
(tools/deps papers); `du` also the recordings, `kleinert-stilla` an hour of processor time."""

import importlib
import sys

PAPERS = {"du": "papers_du", "kleinert-stilla": "papers_kleinert_stilla"}
if len(sys.argv) != 2 or sys.argv[1] not in PAPERS:
    sys.exit(f"studies/papers.py: found {sys.argv[1:]}, expected one of {', '.join(PAPERS)}")
importlib.import_module(f"studies.{PAPERS[sys.argv[1]]}").main()
