"""README.md against studies/results.json: its figures are those of the file, each sentence those of one run,
and no other number stands in it but the EXCEPTIONS below. docs/results.md, studies/results.md and
studies/peers.md likewise are what studies/front_page.py writes. No program is needed."""

import copy
import pathlib
import re
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
from studies import front_page  # noqa: E402

# What README.md may state with a digit that no run has measured: names and versions of others, options,
# the definition of a figure. Longer ones first: each is removed where it stands.
EXCEPTIONS = [
    "https://img.shields.io/badge/C%2B%2B-20-blue", "https://img.shields.io/badge/licence-BSD--3--Clause-blue",
    "https://img.shields.io/badge/Debian_12-Ubuntu_24.04-blue", "BSD-3-Clause", "Ubuntu 24.04", "Debian 12", "C++20",
    "ROS 1", "ROS 2", "docs/ros2.md", "ORB-SLAM3", "MH_01_easy", "window:20", "docs/start.md#8-your-own-program",
    "±3σ", "3σ", "NEES of 6", "in 3D",
]
NUMBER_WORDS = "two|three|four|five|six|seven|eight|nine|ten|twelve|twenty|thirty|hundred|thousand|half|twice"
UNITS = "ms|mm|cm|m|km|s|MB|GB|%|°|milliseconds?|seconds?|minutes?|hours?|metres?|times|per cent"
MOST_LINES = 120


def generated(text, name):
    return text.split(f"<!-- {name}:begin -->\n")[1].split(f"<!-- {name}:end -->")[0]


def written_by_hand(text):
    """README.md without what front_page.py writes into it."""
    for page, name, _ in front_page.BLOCKS:
        if page == front_page.README:
            text = text.replace(generated(text, name), "")
    return text


def numbers(text):
    """The lines' numbers that are no exceptions."""
    for exception in EXCEPTIONS:
        text = text.replace(exception, "")
    words = re.findall(rf"\b(?:{NUMBER_WORDS})\b[ -](?:{UNITS})(?!\w)", text, re.I)
    return [*re.findall(r"\d[\d.,]*", text), *words]


def blanked(value, key=""):
    """The results without a digit, but for keys: what then has digits in a text was not measured."""
    if isinstance(value, dict):
        return {k: blanked(v, k) for k, v in value.items()}
    if isinstance(value, list):
        return [blanked(v, key) for v in value]
    if key == "key" or (key == "cameras"):
        return value
    if isinstance(value, str):
        return re.sub(r"\d", "#", value)
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return float("nan")
    return value


def findings(readme, results):
    """What is wrong with this text of README.md."""
    found = [f"not generated: {number}" for number in numbers(written_by_hand(readme))]
    for page, name, text in front_page.BLOCKS:
        if page == front_page.README and generated(readme, name) != text(results) + "\n":
            found.append(f"not what studies/results.json states: {name}")
    return found


class Readme(unittest.TestCase):
    def setUp(self):
        self.results = front_page.load()
        self.readme = front_page.README.read_text()

    def test_its_figures_are_those_of_the_results(self):
        self.assertEqual(findings(self.readme, self.results), [])

    def test_it_has_at_most_as_many_lines(self):
        self.assertLessEqual(len(self.readme.splitlines()), MOST_LINES)

    def test_other_pages_have_those_figures_too(self):
        for page, name, text in front_page.BLOCKS:
            with self.subTest(page=page.name, block=name):
                self.assertEqual(generated(page.read_text(), name), text(self.results) + "\n")
        self.assertEqual(front_page.VARIANTS.read_text(), front_page.variants_page(self.results))
        self.assertEqual(front_page.PEERS.read_text(), front_page.peers_page(self.results))

    def test_no_text_has_a_figure_of_its_own(self):
        """The templates name runs; rows of cameras stay, as those are what a run is."""
        nothing = blanked(self.results)
        for page, name, text in front_page.BLOCKS:
            if page == front_page.README:
                rendered = re.sub(r"\| +[12] \|", "|", text(nothing))
                with self.subTest(block=name):
                    self.assertEqual(numbers(rendered), [])

    def test_the_claim_is_that_of_one_row_of_the_table(self):
        """Error and time of the same recording with as many cameras: once it paired those of two runs."""
        claim = generated(self.readme, "claim").replace("\n", " ")
        millimetres, name, cameras, ms = re.search(
            r"(\d+) mm error in [\d.]+ s of (.*) with (.*), at ([\d.]+) ms", claim).groups()
        count = {word: str(number) for number, word in front_page.CAMERAS.items()}[cameras]
        rows = [[c.strip() for c in line.strip("|").split("|")]
                for line in generated(self.readme, "inertial").splitlines() if line.startswith("|")]
        ate = [row[2] for row in rows if row[0].startswith(f"ATE m, {name}") and row[1] == count]
        time = [row[2] for row in rows if row[0] == f"CPU ms a frame, {name}" and row[1] == count]
        self.assertEqual([f"{1000 * float(value):.0f}" for value in ate], [millimetres])
        self.assertEqual([value.split("–")[-1] for value in time], [ms])

    def test_the_speeds_are_those_of_the_table(self):
        low, high = re.search(r"(\d+)\s+to\s+(\d+)\s+times", generated(self.readme, "claim")).groups()
        table = generated(front_page.STEREO.read_text(), "results")
        speeds = [int(line.strip("|").split("|")[-1]) for line in table.splitlines()
                  if line.startswith("|") and line.strip("| ").split("|")[-1].strip().isdigit()]
        self.assertEqual((int(low), int(high)), (min(speeds), max(speeds)))


class TheTestItself(unittest.TestCase):
    """It finds what once stood in README.md."""

    def setUp(self):
        self.results = front_page.load()
        self.readme = front_page.README.read_text()

    def test_finds_a_figure_of_another_run(self):
        wrong = re.sub(r"[\d.]+ ms", "2.4 ms", self.readme, count=1)
        self.assertEqual(findings(wrong, self.results), ["not what studies/results.json states: claim"])

    def test_finds_results_that_changed(self):
        changed = copy.deepcopy(self.results)
        for row in changed["visual_inertial"]["rows"]:
            row["chasles"]["compared"]["ate_posyaw_m"] *= 1.3
        self.assertIn("not what studies/results.json states: claim", findings(self.readme, changed))

    def test_finds_a_number_by_hand(self):
        for text in ("It takes 100 s.", "68 to 1043 × real time", "the first takes six minutes", "90 % of all"):
            with self.subTest(text=text):
                wrong = self.readme.replace("## Links\n", f"{text}\n\n## Links\n")
                self.assertTrue(findings(wrong, self.results))


if __name__ == "__main__":
    unittest.main()
