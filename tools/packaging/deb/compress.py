#!/usr/bin/env python3
"""compress.py FROM TO: man pages as Debian wants them, compressed and without times."""
import gzip
import pathlib
import sys


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    source, target = map(pathlib.Path, sys.argv[1:])
    target.mkdir(parents=True, exist_ok=True)
    for old in target.glob("*.gz"):
        old.unlink()
    for page in sorted(source.glob("*.1")):
        (target / f"{page.name}.gz").write_bytes(gzip.compress(page.read_bytes(), 9, mtime=0))


if __name__ == "__main__":
    main()
