"""The documentation site; see docs/build.sh."""

from importlib.metadata import metadata

_about = metadata("building2building")
project = "building2building"
author = _about["Author"]
release = version = _about["Version"]
html_title = f"building2building {version}"

extensions = [
    "myst_parser",
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
autodoc_default_options = {"members": True, "show-inheritance": True}
autodoc_member_order = "bysource"
autodoc_typehints = "description"
# Links to files of the repository have no page.
suppress_warnings = ["myst.xref_missing"]
