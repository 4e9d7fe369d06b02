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
    "sphinx.ext.intersphinx",
    "sphinx_copybutton",
]
myst_heading_anchors = 3
html_theme = "furo"
html_theme_options = {
    "source_repository": "https://github.com/vtaboga/building2building/",
    "source_branch": "main",
    "source_directory": "docs/",
}
autodoc_default_options = {"members": True, "show-inheritance": True}
autodoc_member_order = "bysource"
autodoc_typehints = "description"
intersphinx_mapping = {
    "python": ("https://docs.python.org/3", None),
    "numpy": ("https://numpy.org/doc/stable", None),
    "gymnasium": ("https://gymnasium.farama.org", None),
}
# Links out of the pages to files of the repository, and types of the Rust core, have no page.
suppress_warnings = ["myst.xref_missing", "intersphinx.external"]
