#!/usr/bin/env python3
"""check_formats.py PACKAGES COPYRIGHT: checks the files that other tools read. The recipe of conda-forge
renders with rattler-build, the port of vcpkg calls vcpkg's functions and states its tarball, the
copyright file is complete, and the bill of materials names what the pages contain."""
import hashlib
import json
import pathlib
import re
import sys

from rattler_build import Stage0Recipe
from rattler_build.variant_config import VariantConfig

import components


def check(holds, message):
    if not holds:
        sys.exit(f"check_formats.py: {message}")


def check_recipe(folder, tarball):
    file = folder / "recipe.yaml"
    config = VariantConfig({"c_stdlib": ["sysroot"], "c_stdlib_version": ["2.28"],
                            "python": ["3.12.* *_cpython"]})
    variants = Stage0Recipe.from_file(str(file)).render(config)
    check(len(variants) == 1, f"{file}: found {len(variants)} variants, expected 1")
    recipe = variants[0].recipe.to_dict()
    digest = hashlib.sha256(tarball.read_bytes()).hexdigest()
    check(recipe["source"][0]["sha256"] == digest, f"{file}: the check sum is not that of {tarball}")
    # What conda-forge's linter asks of every recipe.
    sections = re.findall(r"^([a-z]+):", file.read_text(), re.M)
    order = ["context", "package", "source", "build", "requirements", "tests", "about", "extra"]
    check(sections == order, f"{file}: found the sections {sections}, expected {order}")
    for item in ("homepage", "license", "license_file", "summary"):
        check(recipe["about"].get(item), f"{file}: about/{item} is missing")
    check(recipe["extra"].get("recipe-maintainers"), f"{file}: extra/recipe-maintainers is missing")
    both = {"python"} & set(recipe["requirements"]["host"]) & set(recipe["requirements"]["run"])
    check(both, f"{file}: python is for host and run")


def check_port(folder, tarball):
    manifest = json.loads((folder / "vcpkg.json").read_text())
    names = [d if isinstance(d, str) else d["name"] for d in manifest["dependencies"]]
    check(names == sorted(names), f"{folder}/vcpkg.json: dependencies are not sorted")
    keys = [key for key in ("name", "version", "description", "homepage", "license", "supports",
                            "dependencies") if key in manifest]
    check(list(manifest) == keys, f"{folder}/vcpkg.json: found {list(manifest)}, expected the order {keys}")
    port = (folder / "portfile.cmake").read_text()
    digest = hashlib.sha512(tarball.read_bytes()).hexdigest()
    check(digest in port, f"{folder}/portfile.cmake: the check sum is not that of {tarball}")
    calls = re.findall(r"^\s*(vcpkg_\w+)\(", port, re.M)
    for call in ("vcpkg_cmake_configure", "vcpkg_cmake_install", "vcpkg_cmake_config_fixup",
                 "vcpkg_install_copyright"):
        check(calls.count(call) == 1, f"{folder}/portfile.cmake: expected one call of {call}")


def check_copyright(file):
    """Every licence that a paragraph names has its text, and every embedded component is there."""
    text = file.read_text(encoding="utf-8")
    paragraphs = [dict(re.findall(r"^([A-Z][\w-]*):(.*(?:\n .*)*)", part, re.M))
                  for part in text.strip().split("\n\n")]
    check("Format" in paragraphs[0], f"{file}: the first paragraph has no Format")
    files = [p for p in paragraphs if "Files" in p]
    texts = {p["License"].split("\n")[0].strip() for p in paragraphs[1:]
             if "Files" not in p and "\n" in p["License"]}
    for p in files:
        check("Copyright" in p and p["License"].strip() in texts, f"{file}: {p} lacks an owner or a text")
    for component in components.in_the_pages():
        check(component.copyright[0] in text, f"{file}: {component.name} is missing")


def check_bill(file):
    bill = json.loads(file.read_text())
    names = {package["name"] for package in bill["packages"]}
    wanted = {c.name for c in components.in_the_pages()} | {"chasles", "Eigen", "libc6"}
    check(wanted <= names, f"{file}: {sorted(wanted - names)} are missing")


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    packages, copyright_file = map(pathlib.Path, sys.argv[1:])
    tarball = next(packages.glob("chasles-*.tar.gz"))
    check_recipe(packages / "conda", tarball)
    check_port(packages / "vcpkg" / "chasles", tarball)
    check_copyright(copyright_file)
    check_bill(packages / "chasles.spdx.json")


if __name__ == "__main__":
    main()
