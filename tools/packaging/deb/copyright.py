#!/usr/bin/env python3
"""copyright.py FILE: writes the packages' copyright file in Debian's machine-readable format: Chasles,
what is compiled into the binaries, and the npm packages in the report's pages, each with its notice."""
import pathlib
import re
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
import components  # noqa: E402

HEADER = """\
Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: chasles
Comment: Paths below usr/include are those of Debian's packages, from whose headers and archives code
 is compiled into the binaries. The shared libraries that the binaries link are packages of their own,
 with notices of their own. Among them is CHOLMOD of SuiteSparse, which Ceres Solver links: parts of it
 are under the GPL, version 2 or later.
"""

# Full texts, and where Debian has one in its base system.
COMMON = {"MPL-2.0": "MPL-2.0", "Apache-2.0": "Apache-2.0"}


def folded(text):
    """A field's further lines: one space before each, a dot for an empty line."""
    return "\n".join(f" {line.rstrip()}" if line.strip() else " ." for line in text.strip().split("\n"))


def paragraph(files, owners, licence):
    indent = "\n" + " " * len("Copyright: ")
    return f"Files: {files}\nCopyright: {indent.join(owners)}\nLicense: {licence}\n"


def without_owner(text):
    """The terms of a licence file, without its title and its line of copyright."""
    return text[text.index("\n", re.search(r"^Copyright.*", text, re.M).start()):]


def licence_text(name, pages, repository):
    if name in COMMON:
        return f"The full text is in /usr/share/common-licenses/{COMMON[name]}."
    if name == "BSD-3-clause":
        return without_owner((repository / "LICENSE").read_text())
    if name == "Expat":
        return without_owner(pages[0].text)
    return (HERE / f"{name}.txt").read_text()


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    repository = HERE.parents[2]
    try:
        compiled, pages = components.compiled_in(), components.in_the_pages()
    except components.UnknownComponent as error:
        sys.exit(f"copyright.py: {error}")
    parts = [HEADER, paragraph("*", ["The Chasles authors"], "BSD-3-clause"),
             paragraph("src/web/dist/*", [owner for page in pages for owner in page.copyright], "Expat")]
    parts += [paragraph(f"{c.path}/*", c.copyright, c.licence) for c in compiled]
    for name in sorted({"BSD-3-clause", "Expat", *(c.licence for c in compiled)}):
        parts.append(f"License: {name}\n{folded(licence_text(name, pages, repository))}\n")
    pathlib.Path(sys.argv[1]).write_text("\n".join(parts), encoding="utf-8")


if __name__ == "__main__":
    main()
