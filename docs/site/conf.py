"""Sphinx settings of the site; build.py says what is on it."""

project = "flexopt"
extensions = ["myst_parser"]
myst_heading_anchors = 5
highlight_language = "none"
suppress_warnings = ["misc.highlighting_failure"]  # JSON with dots where the reader fills in
html_theme = "furo"
html_title = "flexopt"
html_static_path = ["site.css"]
html_css_files = ["site.css"]
html_show_copyright = False
html_show_sphinx = False
html_copy_source = False
html_last_updated_fmt = None
