"""Settings of the site: ``python -m sphinx -W docs site``, without network."""

from __future__ import annotations

import os
import sys
import warnings
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_extensions"))

import bladesmith  # noqa: E402

warnings.filterwarnings("ignore", category=FutureWarning)  # old names, which are looked at and left out

project = "bladesmith"
author = "bladesmith authors"
copyright = "bladesmith authors, Apache-2.0"
version = release = bladesmith.__version__

extensions = [
    "api_reference",
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.intersphinx",
    "sphinx.ext.mathjax",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
    "sphinx_design",
]
source_suffix = {".md": "myst-nb", ".rst": "restructuredtext"}
exclude_patterns = ["_build"]
templates_path: list[str] = []

myst_enable_extensions = ["colon_fence", "dollarmath", "deflist", "attrs_inline"]
myst_heading_anchors = 4
nb_execution_mode = "off"  # notebooks are run by the tests, and their results kept in no file

default_role = "py:obj"  # `name` in docstrings is a link where there is such a name, else code
autosummary_generate = False
autodoc_member_order = "groupwise"
autodoc_typehints = "none"  # numpydoc says types in words, with shapes
autodoc_preserve_defaults = True
numpydoc_show_class_members = False
numpydoc_xref_param_type = False
python_use_unqualified_type_names = True

# Other projects' names become links where their inventories can be fetched: BLADESMITH_DOCS_ONLINE=1.
intersphinx_mapping = (
    {
        "python": ("https://docs.python.org/3", None),
        "numpy": ("https://numpy.org/doc/stable", None),
        "scipy": ("https://docs.scipy.org/doc/scipy", None),
    }
    if os.environ.get("BLADESMITH_DOCS_ONLINE")
    else {}
)

html_theme = "pydata_sphinx_theme"
html_title = "bladesmith"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {
    "show_toc_level": 2,
    "navigation_with_keys": False,
    "navbar_align": "left",
    "header_links_before_dropdown": 7,
    "footer_start": ["copyright"],
    "footer_end": [],
}
