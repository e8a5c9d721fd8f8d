"""Pages whose tables and pictures the studies make."""

import pathlib
import shutil
import subprocess
import tempfile
import typing

Markers = dict[pathlib.Path, tuple[str, ...]]  # the markers that a study fills, by page

# Keeps only the plan view, once to scale and once with enlarged errors.
PICTURE_SCRIPT = """<style>
body > :not(main), main > :not(#overview), .map-options, .map-buttons, #overview-help { display: none !important; }
#overview-map, .copy { height: 470px !important; width: 100%; display: block; }
.map-frame { border: 0; }
.note { font-size: 14px; margin: 8px 0; }
body { padding: 0; } #overview { border: 0; border-radius: 0; }
</style><script>
addEventListener('load', () => setTimeout(() => {
  const map = document.getElementById('overview-map'), frame = map.parentElement;
  const note = (text) => Object.assign(document.createElement('p'), { className: 'note', textContent: text });
  const copy = Object.assign(document.createElement('img'), { className: 'copy', src: map.toDataURL() });
  frame.before(note('True to scale'), copy, note('Deviations from the truth FACTOR times as large'));
  const factor = document.getElementById('overview-factor');
  factor.value = 'FACTOR';
  factor.dispatchEvent(new Event('change'));
}, 500));
</script>"""


def take_picture(page: pathlib.Path, picture: pathlib.Path, factor: int = 20) -> None:
    """The plan view of a report, with errors enlarged by one of the page's factors."""
    names = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
    browser = next((found for name in names if (found := shutil.which(name))), None)
    if not browser:
        print(f"no Chromium: {picture} stays as it is")
        return
    with tempfile.TemporaryDirectory() as folder:
        copy = pathlib.Path(folder) / "page.html"
        copy.write_text(page.read_text() + PICTURE_SCRIPT.replace("FACTOR", str(factor)))
        subprocess.run([browser, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
                        f"--user-data-dir={folder}/profile", "--virtual-time-budget=4000", "--window-size=1200,1300",
                        f"--screenshot={picture}", f"file://{copy}"], check=True, stderr=subprocess.DEVNULL)


def number(value: float | None, digits: int, factor: float = 1, per: float = 1) -> str:
    return "-" if value is None else f"{value * factor / per:.{digits}f}"


def row(cells: typing.Iterable[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def table(header: typing.Sequence[str], rows: typing.Iterable[typing.Iterable[str]],
          alignment: typing.Iterable[str] | None = None) -> str:
    """`alignment`: "---" or "---:" of each column; without it all columns are aligned to the left."""
    rule = row(alignment) if alignment else "|" + "---|" * len(header)
    return "\n".join([row(header), rule, *map(row, rows)])


def padded_table(header: typing.Sequence[str], rows: typing.Sequence[typing.Sequence[str]]) -> str:
    """With columns of equal width; the first one holds text, the others numbers."""
    widths = [max(len(cells[i]) for cells in [header, *rows]) for i in range(len(header))]

    def padded(cells: typing.Sequence[str]) -> list[str]:
        return [cells[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(cells[1:], widths[1:]))]

    rule = ["-" * widths[0], *("-" * (width - 1) + ":" for width in widths[1:])]
    return table(padded(header), map(padded, rows), rule)


def parts(page: pathlib.Path, name: str) -> tuple[str, str, str]:
    """The text of the file before, between and behind the markers of this name, which stay outside."""
    begin, end = f"<!-- {name}:begin -->\n", f"<!-- {name}:end -->"
    head, rest = page.read_text().split(begin)
    between, tail = rest.split(end)
    return head + begin, between, end + tail


def fill(page: pathlib.Path, name: str, text: str) -> None:
    """Replaces the text of the file between the markers of this name."""
    head, _, tail = parts(page, name)
    page.write_text(head + text + "\n" + tail)
