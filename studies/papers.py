#!/usr/bin/env python3
"""python3 -m studies.papers du | kleinert-stilla: the experiments of a founding paper. It draws the paper's
figures and prints its tables on one page, out/papers/NAME/page.html. It fills docs/papers.md and
studies/papers.md between their markers and draws the pictures. Needs numpy and matplotlib
(tools/deps papers); `du` also the recordings, `kleinert-stilla` an hour of processor time."""

import importlib

from studies.program import parser

PAPERS = {"du": "papers_du", "kleinert-stilla": "papers_kleinert_stilla"}


def main() -> None:
    arguments = parser(__doc__)
    arguments.add_argument("paper", choices=PAPERS)
    importlib.import_module(f"studies.{PAPERS[arguments.parse_args().paper]}").main()


if __name__ == "__main__":
    main()
