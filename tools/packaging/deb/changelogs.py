#!/usr/bin/env python3
"""changelogs.py VERSION MAINTAINER CHANGELOG FOLDER: writes changelog.Debian.gz, which names the version
of the package, and changelog.gz, the project's own. The date is that of $SOURCE_DATE_EPOCH, or now."""
import email.utils
import gzip
import os
import pathlib
import sys
import time

ENTRY = """\
chasles ({version}) unstable; urgency=medium

  * Packages of Chasles {upstream}. changelog.gz lists what changed.

 -- {maintainer}  {date}
"""


def write(file, text):
    # No name and no time in the header: the same text gives the same bytes.
    with open(file, "wb") as raw, gzip.GzipFile("", "wb", 9, raw, mtime=0) as stream:
        stream.write(text.encode())


def main():
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    version, maintainer, changelog, folder = sys.argv[1:]
    epoch = int(os.environ.get("SOURCE_DATE_EPOCH") or time.time())
    entry = ENTRY.format(version=version, upstream=version.partition("-")[0], maintainer=maintainer,
                         date=email.utils.formatdate(epoch))
    write(pathlib.Path(folder) / "changelog.Debian.gz", entry)
    write(pathlib.Path(folder) / "changelog.gz", pathlib.Path(changelog).read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
