"""The documentation site; see docs/build.sh."""

import os
from importlib.metadata import metadata
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.util import logging

_about = metadata("building2building")
project = "building2building"
author = _about["Author"]
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
html_theme_options = {
    "source_repository": "https://github.com/vtaboga/building2building/",
    "source_branch": "main",
    "source_directory": "docs/",
}
html_static_path = ["static"]
html_css_files = ["site.css"]
autodoc_default_options = {"members": True, "show-inheritance": True}
autodoc_member_order = "bysource"
autodoc_typehints = "description"

# Tutorials run when the site is built; their outputs are kept until their text changes.
nb_execution_mode = os.environ.get("B2B_DOCS_EXECUTE", "cache")
nb_execution_cache_path = str(Path(os.environ.get("CARGO_TARGET_DIR", "target")).resolve() / "docs/executed")
nb_execution_timeout = 1800
nb_execution_raise_on_error = True
nb_execution_in_temp = True

# Links to files of the repository have no page: `_check_link` looks for the file.
suppress_warnings = ["myst.xref_missing"]
_ROOT = Path(os.environ.get("B2B_ROOT", ".")).resolve()


def _check_link(app: Sphinx, env: object, node: object, content: object) -> None:
    """Warns of a link to what is neither a page nor a file of the repository."""
    target = node["reftarget"]  # type: ignore[index]
    path, _, _ = target.partition("#")
    if node.get("reftype") != "myst" or "://" in target:  # type: ignore[attr-defined]
        return
    folder = Path("docs") / Path(node["refdoc"]).parent  # type: ignore[index]
    places = (_ROOT / folder / path, _ROOT / path)
    if not path or path.endswith(".md") and "docs" in str(folder / path) and not _leaves_docs(folder / path):
        logging.getLogger(__name__).warning(f"broken link to `{target}`", location=node)
    elif not any(each.exists() for each in places):
        logging.getLogger(__name__).warning(f"link to `{target}`, which does not exist", location=node)


def _leaves_docs(path: Path) -> bool:
    return Path(os.path.normpath(path)).parts[:1] != ("docs",)


def setup(app: Sphinx) -> None:
    """Has links checked."""
    app.connect("missing-reference", _check_link)
