#!/usr/bin/env python3
"""check_links.py SITE: each link of the site's pages leads to a file of it, and to an anchor there.

It also fails where a page would fetch something from elsewhere.
"""
import html.parser
import pathlib
import sys
import urllib.parse


class Page(html.parser.HTMLParser):
    def __init__(self, file):
        super().__init__()
        self.anchors, self.links, self.fetched = {""}, set(), set()
        self.feed(file.read_text())

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.anchors |= {attributes[name] for name in ("id", "name") if attributes.get(name)}
        if tag == "a" and "href" in attributes:
            self.links.add(attributes["href"])
        elif link := attributes.get("src") or (tag == "link" and attributes.get("href")):
            self.links.add(link)
            self.fetched.add(link)


def main(site):
    api = site / "api"  # Doxygen checks its own links
    pages = {file: Page(file) for file in sorted(site.rglob("*.html")) if api not in file.parents}
    errors = []
    for file, page in pages.items():
        for link in sorted(page.links):
            url = urllib.parse.urlsplit(link)
            target = file if not url.path else (file.parent / urllib.parse.unquote(url.path)).resolve()
            if url.scheme or url.netloc:
                error = "is fetched from elsewhere" if link in page.fetched else None
            elif target.is_dir() or not target.is_file():
                error = None if target == site else "leads to no file"
            else:
                known = pages[target].anchors if target in pages else {urllib.parse.unquote(url.fragment)}
                error = None if urllib.parse.unquote(url.fragment) in known else "leads to no heading"
            if error:
                errors.append(f"{file.relative_to(site)}: {link} {error}")
    print("\n".join(errors + [f"links: {len(pages)} pages, {len(errors)} errors"]))
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1]).resolve()))
