#!/usr/bin/env python3
"""stage.py FOLDER: puts the site's Markdown pages into FOLDER, for mkdocs.

The pages of docs/ keep their names; those of studies/ go to studies/, and README.md and CHANGELOG.md to
repository/. A link to any other file of the repository leads to a page in repository/ that shows the file.
"""
import os
import pathlib
import re
import shutil
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
LINK = re.compile(r"(?<=\]\()([^)\s#:]+)(?=[)#])")
LANGUAGES = {".hpp": "cpp", ".cpp": "cpp", ".yaml": "yaml", ".py": "python", ".json": "json"}


class Stage:
    def __init__(self, folder):
        self.folder = folder
        docs = ROOT / "docs"
        self.places = {f: f.relative_to(docs) for f in docs.rglob("*") if f.is_file()}
        self.places |= {f: f.relative_to(ROOT) for f in (ROOT / "studies").glob("*.md")}
        for name in ("README.md", "CHANGELOG.md"):
            self.places[ROOT / name] = pathlib.Path("repository", name)
        self.waiting = list(self.places)

    def place(self, file):
        """Where a file of the repository is in the site."""
        if file not in self.places:
            self.places[file] = pathlib.Path("repository", file.relative_to(ROOT).as_posix() + ".md")
            self.waiting.append(file)
        return self.places[file]

    def page(self, file):
        """A Markdown page with its links led to the site's pages."""
        here = self.place(file).parent

        def lead(link):
            target = pathlib.Path(os.path.normpath(file.parent / link[1]))
            if not target.exists() or ROOT not in target.parents:
                return link[1]  # mkdocs reports it
            return os.path.relpath(self.place(target), here)

        fenced = False
        lines = []
        for line in file.read_text().splitlines():
            fenced ^= line.lstrip().startswith("```")
            lines.append(line if fenced else LINK.sub(lead, line))
        return "\n".join(lines) + "\n"

    def folder_page(self, folder):
        """A page that lists the files of a folder."""
        here = self.place(folder).parent
        files = [file for file in sorted(folder.iterdir()) if file.is_file()]
        links = [f"- [{file.name}]({os.path.relpath(self.place(file), here)})" for file in files]
        return "\n".join([f"# {folder.relative_to(ROOT)}", "", *links, ""])

    def source(self, file):
        """A page that shows a file which is no page."""
        name = file.relative_to(ROOT).as_posix()
        code = file.read_text()
        fence = "`" * 8
        return (f"---\nsearch:\n  exclude: true\n---\n# {name}\n\n"
                f"{fence} {LANGUAGES.get(file.suffix, 'text')}\n{code}\n{fence}\n")

    def run(self):
        while self.waiting:
            file = self.waiting.pop()
            target = self.folder / self.places[file]
            target.parent.mkdir(parents=True, exist_ok=True)
            if file.is_dir():
                target.write_text(self.folder_page(file))
            elif file.suffix == ".md":
                target.write_text(self.page(file))
            elif ROOT / "docs" in file.parents:
                shutil.copy(file, target)
            else:
                target.write_text(self.source(file))


if __name__ == "__main__":
    Stage(pathlib.Path(sys.argv[1])).run()
