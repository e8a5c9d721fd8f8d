#!/usr/bin/env python3
"""offline_search.py SITE: lets the search of a site of Material for MkDocs work without a server.

The index and the search's worker become scripts. theme/main.html loads them if a page comes from a file.
"""
import json
import pathlib
import sys

WORKER = """(() => {
  const source = URL.createObjectURL(new Blob([%s], { type: "text/javascript" }));
  const FromUrl = Worker;
  window.Worker = function () { return new FromUrl(source); };
})();
"""

site = pathlib.Path(sys.argv[1])
index = (site / "search/search_index.json").read_text()
(site / "search/search_index.js").write_text(
    f"var __index = {index};\nwindow.__search = {{ index: Promise.resolve(__index) }};\n")
(worker,) = (site / "assets/javascripts/workers").glob("search.*.min.js")
(site / "search/search_worker.js").write_text(WORKER % json.dumps(worker.read_text()))
