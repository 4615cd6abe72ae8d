"""How Sphinx builds the documentation: `./dev docs`."""

import rotorpong

project = "rotorpong"
author = "The rotorpong developers"
copyright = author
version = release = rotorpong.__version__

extensions = ["myst_parser"]
myst_heading_anchors = 3

html_theme = "furo"
html_title = "rotorpong"
html_copy_source = False
html_show_sphinx = False
