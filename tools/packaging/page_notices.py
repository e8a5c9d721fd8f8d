#!/usr/bin/env python3
"""page_notices.py FILE: the licences of the npm packages in the report's pages, for the source
tarball, which has the pages built."""
import pathlib
import sys

import components


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    try:
        found = components.in_the_pages()
    except components.UnknownComponent as error:
        sys.exit(f"page_notices.py: {error}")
    parts = [f"{c.name} {c.version}\n\n{c.text.strip()}\n" for c in found]
    text = "The pages in this folder contain these npm packages.\n\n" + ("-" * 78 + "\n\n").join(
        part + "\n" for part in parts)
    pathlib.Path(sys.argv[1]).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
