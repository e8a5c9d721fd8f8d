#!/usr/bin/env python3
"""The package studies/ without a study: its modules, their command lines, and the pages that they fill. A module whose
Debian packages (tools/deps dev papers) are missing is left out."""
import ast
import contextlib
import importlib
import io
import os
import pathlib
import pkgutil
import re
import subprocess
import sys
import unittest
import unittest.mock

ROOT = pathlib.Path(__file__).resolve().parent.parent
OPTIONAL = ("numpy", "matplotlib", "scipy")
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT))
# No study may run the program.
os.environ["CHASLES_BINARY"] = "/nonexistent/chasles"

NAMES = sorted(module.name for module in pkgutil.iter_modules([str(ROOT / "studies")]))
SOURCES = {name: (ROOT / f"studies/{name}.py").read_text(encoding="utf-8") for name in NAMES}


def imported():
    """The modules by name."""
    found = {}
    for name in NAMES:
        try:
            found[name] = importlib.import_module(f"studies.{name}")
        except ModuleNotFoundError as error:
            if error.name not in OPTIONAL:
                raise
    return found


def called(module, *arguments):
    """(exit code, standard output, standard error) of a study that ends before its first command."""
    out, err = io.StringIO(), io.StringIO()
    with (unittest.mock.patch.object(sys, "argv", ["study", *arguments]), contextlib.redirect_stdout(out),
          contextlib.redirect_stderr(err)):
        try:
            module.main()
        except SystemExit as end:
            return end.code, out.getvalue(), err.getvalue()
    raise AssertionError(f"{module.__name__} ran with {arguments}")


def filled(name):
    """The literal names in a module's calls of fill()."""
    calls = [node for node in ast.walk(ast.parse(SOURCES[name])) if isinstance(node, ast.Call)
             and getattr(node.func, "id", getattr(node.func, "attr", "")) == "fill" and len(node.args) == 3]
    return bool(calls), {node.args[1].value for node in calls if isinstance(node.args[1], ast.Constant)}


class Studies(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.modules = imported()
        cls.studies = [name for name in cls.modules if '__name__ == "__main__"' in SOURCES[name]]

    def test_importing_runs_nothing(self):
        """Each module defines, and calls nothing but what it defines with: main() runs below `__main__` alone."""
        for name in NAMES:
            calls = [node for node in ast.parse(SOURCES[name]).body
                     if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call)]
            with self.subTest(name):
                self.assertNotIn("main", [getattr(node.value.func, "id", "") for node in calls])
        self.assertIn("table", self.modules)

    def test_help(self):
        for name in self.studies:
            with self.subTest(name):
                code, out, err = called(self.modules[name], "--help")
                self.assertEqual((code, err), (0, ""))
                self.assertTrue(out.startswith(f"usage: python3 -m studies.{name} "), out)
                self.assertTrue(self.modules[name].__doc__.startswith(f"python3 -m studies.{name}"))

    def test_wrong_arguments(self):
        wrong = {name: ("--no-such-option", "error: ") for name in self.studies}
        wrong |= {"study": ("many", "invalid count value: 'many'"),
                  "inertial": ("no-table", "found 'no-table', expected one of april, flights, walks"),
                  "papers": ("no-paper", "invalid choice: 'no-paper'")}
        for name, (argument, message) in wrong.items():
            with self.subTest(name):
                code, _, err = called(self.modules[name], argument)
                self.assertEqual(code, 2)
                self.assertIn(f"python3 -m studies.{name}: error: ", err)
                self.assertIn(message, err)

    def test_as_a_command(self):
        """From the repository's root; a program that is not there is named."""
        command = [sys.executable, "-m", "studies.recordings_consistency", "--quick"]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("there is no /nonexistent/chasles", done.stderr)

    def test_the_markers_are_in_the_pages(self):
        for name in NAMES:
            fills, literal = filled(name)
            with self.subTest(name):
                if not fills:
                    self.assertNotIn("MARKERS = ", SOURCES[name])
                    continue
                self.assertIn("\nMARKERS = ", SOURCES[name])
                if name not in self.modules:
                    continue
                pages = self.modules[name].MARKERS
                self.assertLessEqual(literal, {marker for markers in pages.values() for marker in markers})
                for page, markers in pages.items():
                    text = page.read_text(encoding="utf-8")
                    for marker in markers:
                        places = [text.find(f"<!-- {marker}:{end} -->") for end in ("begin", "end")]
                        self.assertTrue(0 <= places[0] < places[1], f"{page}: {marker}")

    def test_every_marker_of_the_folder_is_filled(self):
        """A page here has no table that no study fills."""
        if len(self.modules) < len(NAMES):
            self.skipTest("packages of tools/deps dev papers are missing")
        known = {(page, marker) for module in self.modules.values()
                 for page, markers in getattr(module, "MARKERS", {}).items() for marker in markers}
        for page in (ROOT / "studies").glob("*.md"):
            for marker in re.findall(r"<!-- (\S+):begin -->", page.read_text(encoding="utf-8")):
                self.assertIn((page, marker), known)

    def test_lines_have_120_characters_at_most(self):
        for name, text in SOURCES.items():
            for number, line in enumerate(text.splitlines(), 1):
                self.assertLessEqual(len(line), 120, f"studies/{name}.py:{number}")

    def test_the_configurations_exist(self):
        for name, text in SOURCES.items():
            for file in re.findall(r'"(studies/configs/[\w.-]+\.yaml)"', text):
                self.assertTrue((ROOT / file).is_file(), f"studies/{name}.py: {file}")

    def test_bands(self):
        # 2.5 % and 97.5 % quantiles of chi-square with 30 and 100 degrees of freedom, from tables.
        for dof, count, *quantiles in ((3, 10, 16.791, 46.979), (1, 100, 74.222, 129.561)):
            for limit, quantile in zip(self.modules["bands"].mean_band(dof, count), quantiles):
                self.assertAlmostEqual(limit, quantile / (dof * count), delta=1e-3)

    def test_tables(self):
        pages = self.modules["pages"]
        self.assertEqual(pages.table(["a", "b"], [["1", "2"]]), "| a | b |\n|---|---|\n| 1 | 2 |")
        self.assertEqual(pages.table(["a", "b"], [["1", "2"]], ["---", "---:"]), "| a | b |\n| --- | ---: |\n| 1 | 2 |")
        self.assertEqual(pages.padded_table(["of", "b"], [["c", "123"]]), "| of |   b |\n| -- | --: |\n| c  | 123 |")
        self.assertEqual([pages.number(None, 1), pages.number(0.25, 1, 100), pages.number(3, 1, per=2)], ["-", "25.0", "1.5"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
