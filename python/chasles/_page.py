"""What has an HTML page: it can be shown in a notebook, and written to a file."""

import html


class Page:
    """Base of the results that have a page(), one HTML document that loads nothing, as text."""

    def show(self, path):
        """Writes the page to a file."""
        with open(path, "w", encoding="utf-8") as file:
            file.write(self.page())

    def _repr_html_(self):
        return (f'<iframe srcdoc="{html.escape(self.page())}" style="width: 100%; height: 700px; border: 0" '
                f'sandbox="allow-scripts"></iframe>')
