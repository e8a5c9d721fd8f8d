#!/usr/bin/env python3
"""python3 -m studies.study [RUNS]: the Monte Carlo study of studies/consistency.md. It runs the scenes hallway
and turntable, 100 times (or RUNS) each. The filters are Kleinert & Stilla's, the default in every
chart, and one with early landmark initialisation (studies/configs/early.yaml), all on the same noise. It
fills the page between its markers. out/study keeps the studies, and an interrupted one resumes."""

from studies.pages import fill, padded_table
from studies.program import CONFIGS, ROOT, Arguments, chasles, count, parser, sets

PAGE = ROOT / "studies/consistency.md"
SCENES = ("hallway", "turntable")
MARKERS = {PAGE: SCENES}
CHARTS = ["--charts", "standard,left-se3,right-se3,right-sen3", "--landmarks", "inverse-depth"]
# Settings of --set are those of all filters of a command, so the assumed depth has a command of its own.
FILTERS: dict[str, Arguments] = {
    "default": ["--preset", "paper,default", "--config", CONFIGS / "early.yaml", *CHARTS, "--init", "multi-view"],
    "fixed-depth": [*CHARTS, "--init", "fixed-depth", *sets("inverse_depth=0.3", "inverse_depth_sigma=0.3")],
}


def tables(scene: str, runs: int, name: str) -> list[tuple[str, list[list[str]]]]:
    """The two tables of a study, each with its title: rows of cells."""
    folder = ROOT / "out/study" / f"{scene}-{name}-{runs}"
    folder.parent.mkdir(parents=True, exist_ok=True)
    text = chasles("montecarlo", scene, "--runs", runs, *FILTERS[name], "--markdown", "--resume", "-o", folder).stdout
    found: list[tuple[str, list[list[str]]]] = []
    for line in text.strip().splitlines():
        if line.startswith("### "):
            found.append((line, []))
        elif line.startswith("|"):
            found[-1][1].append([cell.strip() for cell in line.strip("|").split("|")])
    return found


def study(scene: str, runs: int) -> str:
    pairs = zip(tables(scene, runs, "default"), tables(scene, runs, "fixed-depth"))
    return "\n\n".join(f"{title}\n\n{padded_table(head, rows + more)}"
                       for (title, (head, _, *rows)), (_, (_, _, *more)) in pairs)


def main() -> None:
    arguments = parser(__doc__)
    arguments.add_argument("runs", nargs="?", type=count, default=100, metavar="RUNS")
    runs = arguments.parse_args().runs
    for scene in SCENES:
        fill(PAGE, scene, study(scene, runs))


if __name__ == "__main__":
    main()
