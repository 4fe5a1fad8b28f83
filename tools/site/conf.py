"""The documentation site: tools/docs builds it."""

import os
import re
from pathlib import Path

from pygments.lexers.special import TextLexer

ROOT = Path(__file__).resolve().parents[2]

project = "polhode"
release = re.search(r"project\(polhode VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text())[1]
extensions = ["myst_nb", "sphinx.ext.autodoc"]
html_theme = "furo"
html_title = f"polhode {release}"
suppress_warnings = ["duplicate_declaration.cpp"]  # every header opens the namespace again

source_suffix = {".md": "myst-nb", ".ipynb": "myst-nb", ".rst": "restructuredtext"}
nb_execution_mode = "off"  # the tests execute the notebooks; they hold what these printed
myst_heading_anchors = 5

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_default_options = {"members": True, "undoc-members": True, "special-members": "__init__, __call__"}
python_use_unqualified_type_names = True

doxygen_xml = os.environ.get("POLHODE_DOXYGEN_XML")  # where Doxygen wrote; empty: it is not installed
if doxygen_xml:
    extensions.append("breathe")
    breathe_projects = {"polhode": doxygen_xml}
    breathe_default_project = "polhode"
    breathe_default_members = ("members", "undoc-members")


def setup(app):
    app.add_lexer("mermaid", TextLexer)  # a drawing on some pages' hosts, text here
