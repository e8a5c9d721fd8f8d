"""What has an HTML page: it can be shown in a notebook, and written to a file."""

from __future__ import annotations

import html
import os


class Page:
    """Base of the results that have a page(), one HTML document that loads nothing, as text."""

    def page(self) -> str:
        raise NotImplementedError

    def show(self, path: str | os.PathLike[str]) -> None:
        """Writes the page to a file."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self.page())

    def _repr_html_(self) -> str:
        return (f'<iframe srcdoc="{html.escape(self.page())}" style="width: 100%; height: 700px; border: 0" '
                f'sandbox="allow-scripts"></iframe>')
