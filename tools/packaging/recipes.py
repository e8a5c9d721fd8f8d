#!/usr/bin/env python3
"""recipes.py TARBALL FOLDER: the files for conda-forge and vcpkg, conda/ and vcpkg/ in the folder: those
beside this script with version, address ($CHASLES_URL) and check sums of the source tarball."""
import hashlib
import os
import pathlib
import re
import shutil
import sys

HERE = pathlib.Path(__file__).resolve().parent
NOWHERE = "https://chasles.invalid"  # until it is published


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    tarball, out = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    version = re.fullmatch(r"chasles-(\d+\.\d+\.\d+)\.tar\.gz", tarball.name)
    if not version:
        sys.exit(f"recipes.py: found {tarball.name}, expected chasles-VERSION.tar.gz")
    data = tarball.read_bytes()
    values = {"VERSION": version[1], "URL": os.environ.get("CHASLES_URL", NOWHERE).rstrip("/"),
              "SHA256": hashlib.sha256(data).hexdigest(), "SHA512": hashlib.sha512(data).hexdigest()}
    for kind in ("conda", "vcpkg"):
        shutil.rmtree(out / kind, ignore_errors=True)
        for source in sorted((HERE / kind).rglob("*")):
            if source.is_dir():
                continue
            target = out / kind / source.relative_to(HERE / kind)
            target.parent.mkdir(parents=True, exist_ok=True)
            text = re.sub(r"@([A-Z0-9]+)@", lambda m: values[m[1]], source.read_text())
            target.with_name(target.name.removesuffix(".in")).write_text(text)


if __name__ == "__main__":
    main()
