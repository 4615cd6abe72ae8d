"""How Sphinx builds the documentation: `./dev docs`.

Examples are executed on every build; pictures, output and downloads of them go to `docs/gallery`,
which git ignores. Nothing is fetched from elsewhere, neither by the build nor by its pages.
"""

import os
import sys
import typing
from pathlib import Path
from typing import Any

DOCS = Path(__file__).resolve().parent
sys.path.insert(0, str(DOCS))
os.environ["SOURCE_DATE_EPOCH"] = os.environ.get("SOURCE_DATE_EPOCH", "1700000000")
setattr(typing, "GENERATING_DOCUMENTATION", "rotorpong")  # noqa: B010 - jaxtyping asks for it

import rotorpong  # noqa: E402 - after jaxtyping was told to write its shapes readably

project = "rotorpong"
author = "The rotorpong developers"
copyright = author
version = release = rotorpong.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_gallery.gen_gallery",
]
default_role = "py:obj"
highlight_language = "none"  # of what stands indented in docstrings: equations, commands
myst_heading_anchors = 3

autodoc_default_options = {"members": True}
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
autoclass_content = "both"
napoleon_numpy_docstring = False
napoleon_custom_sections = [("Fields", "params_style")]
python_maximum_signature_line_length = 88
python_use_unqualified_type_names = True
add_module_names = False
toc_object_entries_show_parents = "hide"

sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "within_subsection_order": "gallery_order.place",
    "run_stale_examples": True,  # an example is the same, what it calls may not be
    "abort_on_example_error": True,
    "notebook_extensions": set(),
    "download_all_examples": False,
    "show_signature": False,
    "min_reported_time": 1e9,
    "write_computation_times": False,
}

html_theme = "furo"
html_title = "rotorpong"
html_copy_source = False
html_show_sourcelink = False
html_show_sphinx = False
html_static_path = ["static"]
html_css_files = ["rotorpong.css"]


def setup(app: Any) -> None:
    """Let docstrings be read as they are written."""
    from docstrings import is_left_out, prepare, without_zip

    app.connect("autodoc-process-docstring", prepare, priority=400)  # before napoleon
    app.connect("autodoc-skip-member", is_left_out)
    app.connect("source-read", without_zip)
