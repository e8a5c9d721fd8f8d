#!/usr/bin/env python3
"""The files of tools/packaging/ and the pages of the program: what holds without making packages.
Arguments: the source folder, a built page."""
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

SOURCE, PAGE = map(pathlib.Path, sys.argv[1:3])
sys.path.insert(0, str(SOURCE / "tools/packaging"))
import components  # noqa: E402


class Packaging(unittest.TestCase):
    def test_one_version_everywhere(self):
        version = re.search(r"project\(chasles VERSION (\S+)", (SOURCE / "CMakeLists.txt").read_text())[1]
        self.assertIn(f'version = "{version}"', (SOURCE / "pyproject.toml").read_text())
        page = (SOURCE / "docs/packages.md").read_text()
        minor = version.rpartition(".")[0]
        for word in (f"chasles-{version}.tar.gz", f"libchasles{minor}_", f"libchasles.so.{minor}"):
            self.assertIn(word, page)

    def test_the_pages_import_dependencies_alone(self):
        """What src/web/src imports is in the pages: components.py takes it from `dependencies`."""
        dependencies = json.loads((SOURCE / "src/web/package.json").read_text())["dependencies"]
        imported = set()
        for file in (SOURCE / "src/web/src").glob("*.ts"):
            imported |= set(re.findall(r"from '([^.'][^'/]*)", file.read_text(encoding="utf-8")))
        self.assertEqual(imported, set(dependencies))

    def test_a_page_has_the_notices_of_what_is_in_it(self):
        page = PAGE.read_text(encoding="utf-8")
        for component in components.in_the_pages():
            owner = re.search(r"^Copyright.*$", component.text, re.M)[0]
            self.assertIn(owner, page)
            self.assertIn(component.text.strip().split("\n")[-1], page)

    def test_a_library_without_a_licence_is_an_error(self):
        table = components.table
        components.table = lambda: {"linked": {}}
        try:
            with self.assertRaisesRegex(components.UnknownComponent, "components.json"):
                components.linked([pathlib.Path("/bin/ls").resolve()])
        finally:
            components.table = table

    def test_recipes_have_the_sums_of_the_tarball(self):
        with tempfile.TemporaryDirectory() as folder:
            tarball = pathlib.Path(folder) / "chasles-1.2.3.tar.gz"
            tarball.write_bytes(b"abc")
            command = [sys.executable, SOURCE / "tools/packaging/recipes.py"]
            subprocess.run([*command, tarball, folder], check=True)
            recipe = (pathlib.Path(folder) / "conda/recipe.yaml").read_text()
            port = (pathlib.Path(folder) / "vcpkg/chasles/portfile.cmake").read_text()
            self.assertIn("ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad", recipe)
            self.assertIn('version: "1.2.3"', recipe)
            self.assertIn("ddaf35a193617abacc417349ae20413112e6fa4e89a97ea20a9eeee64b55d39a", port)
            other = pathlib.Path(folder) / "chasles.zip"
            other.touch()
            failed = subprocess.run([*command, other, folder], capture_output=True, text=True)
            self.assertEqual(failed.returncode, 1)
            self.assertIn("found chasles.zip, expected chasles-VERSION.tar.gz", failed.stderr)

    def test_figures_of_another_machine_are_compared(self):
        with tempfile.TemporaryDirectory() as folder:
            ours, theirs = pathlib.Path(folder) / "a", pathlib.Path(folder) / "b"
            ours.write_text("x 1 2\ny 3\n")
            theirs.write_text("x 1 2.0000002\ny 3\n")
            command = [sys.executable, SOURCE / "tools/packaging/arm64/compare.py", ours, theirs]
            self.assertEqual(subprocess.run([*command, "2e-7"], capture_output=True).returncode, 0)
            self.assertEqual(subprocess.run([*command, "0.5e-7"], capture_output=True).returncode, 1)
            theirs.write_text("x 1 nan\ny 3\n")
            self.assertEqual(subprocess.run([*command, "1"], capture_output=True).returncode, 1)
            theirs.write_text("x 1 2\n")
            self.assertEqual(subprocess.run([*command, "1"], capture_output=True).returncode, 1)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
