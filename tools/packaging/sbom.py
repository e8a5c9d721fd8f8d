#!/usr/bin/env python3
"""sbom.py --version V --output FILE [--loaded LIBRARY] BINARY...: writes the software bill of materials
of the binaries as SPDX 2.3 JSON: what is compiled into them, what the report's pages contain, and
which shared libraries they link or load. The date is that of $SOURCE_DATE_EPOCH."""
import argparse
import datetime
import hashlib
import json
import os
import pathlib
import re
import sys

import components

LINKS = {"compiled in": "STATIC_LINK", "in the pages": "CONTAINS", "linked": "DYNAMIC_LINK"}


def identifier(component):
    return "SPDXRef-" + re.sub(r"[^A-Za-z0-9.-]+", "-", f"{component.kind}-{component.name}")


def package(component):
    return {
        "SPDXID": identifier(component), "name": component.name, "versionInfo": component.version,
        "downloadLocation": "NOASSERTION", "filesAnalyzed": False,
        "licenseConcluded": "NOASSERTION", "licenseDeclared": component.spdx,
        "copyrightText": "\n".join(component.copyright) or "NOASSERTION",
        "externalRefs": [{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl",
                          "referenceLocator": component.purl}]}


def relation(component):
    root = "SPDXRef-chasles"
    if component.kind == "loaded":
        return {"spdxElementId": identifier(component), "relatedSpdxElement": root,
                "relationshipType": "RUNTIME_DEPENDENCY_OF"}
    return {"spdxElementId": root, "relatedSpdxElement": identifier(component),
            "relationshipType": LINKS[component.kind]}


def document(version, found):
    epoch = int(os.environ.get("SOURCE_DATE_EPOCH") or datetime.datetime.now().timestamp())
    created = datetime.datetime.fromtimestamp(epoch, datetime.timezone.utc)
    root = {
        "SPDXID": "SPDXRef-chasles", "name": "chasles", "versionInfo": version,
        "downloadLocation": "NOASSERTION", "filesAnalyzed": False,
        "licenseConcluded": "BSD-3-Clause", "licenseDeclared": "BSD-3-Clause",
        "copyrightText": "The Chasles authors"}
    packages = [root, *map(package, found)]
    # The same content has the same name, and another one another.
    digest = hashlib.sha256(json.dumps(packages, sort_keys=True).encode()).hexdigest()[:32]
    return {
        "spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT",
        "name": f"chasles-{version}", "documentNamespace": f"urn:sbom:chasles-{version}-{digest}",
        "creationInfo": {"created": created.strftime("%Y-%m-%dT%H:%M:%SZ"),
                         "creators": ["Organization: The Chasles authors", "Tool: tools/packaging/sbom.py"]},
        "packages": packages,
        "relationships": [{"spdxElementId": "SPDXRef-DOCUMENT", "relatedSpdxElement": "SPDXRef-chasles",
                           "relationshipType": "DESCRIBES"}, *map(relation, found)]}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--version", required=True)
    parser.add_argument("--output", required=True, type=pathlib.Path)
    parser.add_argument("--loaded", help="file name of a library that is opened at run time")
    parser.add_argument("binaries", nargs="+", type=pathlib.Path)
    options = parser.parse_args()
    try:
        found = [*components.compiled_in(), *components.in_the_pages(),
                 *components.linked(options.binaries)]
        if options.loaded:
            found += components.loaded(options.loaded)
    except components.UnknownComponent as error:
        sys.exit(f"sbom.py: {error}")
    options.output.write_text(json.dumps(document(options.version, found), indent=1) + "\n")


if __name__ == "__main__":
    main()
