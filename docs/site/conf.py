"""The documentation site; see docs/build.sh."""

import os
import re
from importlib.metadata import metadata
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.util import logging

_about = metadata("building2building")
project = "building2building"
author = copyright = _about["Author"]
release = version = _about["Version"]
html_title = f"building2building {version}"

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx_copybutton",
]
myst_heading_anchors = 3
# Included in the first page.
exclude_patterns = ["README.md"]
html_theme = "furo"
html_static_path = ["static"]
html_css_files = ["site.css"]
autodoc_default_options = {"members": True, "show-inheritance": True}
autodoc_member_order = "bysource"
autodoc_typehints = "description"
# Optional dependencies that the site does not need.
autodoc_mock_imports = ["ray"]

# Tutorials run when the site is built; their outputs are kept until their text changes.
nb_execution_mode = os.environ.get("B2B_DOCS_EXECUTE", "cache")
nb_execution_cache_path = str(Path(os.environ.get("CARGO_TARGET_DIR", "target")).resolve() / "docs/executed")
nb_execution_timeout = 1800
nb_execution_raise_on_error = True
nb_execution_in_temp = True

_LINK = re.compile(r"\[([^]]+)\]\((\.\./[^)#\s]+)(?:#[^)\s]*)?\)")


def _name_files(app: Sphinx, page: str, source: list[str]) -> None:
    """Replaces links to files of the repository that have no page by the path of the file, and warns if a file does not
    exist. MyST warns about broken links between pages."""
    folder = Path("docs") / Path(page).parent

    def named(match: re.Match[str]) -> str:
        path = os.path.normpath(folder / match[2])
        if path.startswith("docs/"):
            return match[0]
        if not Path(path).exists():
            logging.getLogger(__name__).warning(f"link to `{match[2]}`, which does not exist", location=page)
        return match[1] if path in match[1] else f"{match[1]} (`{path}`)"

    source[0] = _LINK.sub(named, source[0])


def setup(app: Sphinx) -> None:
    """Connects the rewriting of links. Sphinx runs in the root of the repository."""
    app.connect("source-read", _name_files)
