"""The documentation site: `make docs` builds it into docs/_build/html.

The source folder of Sphinx is the root of the repository, so that README, CONTRIBUTING and the page
of configuration keys are pages of the site, and links work on the site and in a code browser.
"""

from importlib.metadata import version as version_of

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

from skewbridge.study.processes import hush_exit_message

hush_exit_message()

project = "skewbridge"
project_copyright = "the authors of skewbridge"
release = version_of("skewbridge")

root_doc = "docs/index"
include_patterns = [
    "README.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "config/README.md",
    "motions/README.md",
    "docs/**",
]
exclude_patterns = ["docs/_build/**"]

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
]
myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

default_role = "code"  # docstrings quote names by single marks
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_default_options = {"members": True}
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True

html_theme = "furo"
html_title = "skewbridge"
templates_path = ["_templates"]
html_static_path = ["_static"]
html_css_files = ["equations.css"]
# The first page is in docs/; index.html of the site redirects to it.
html_additional_pages = {"index": "start.html"}
html_copy_source = False
html_math_renderer = "mathml"


def setup(app: Sphinx) -> None:
    """Write equations as MathML, so that the site is complete without a network."""
    app.add_html_math_renderer("mathml", (_inline, None), (_display, None))


def _inline(translator: HTML5Translator, node: nodes.math) -> None:
    translator.body.append(convert(node.astext()))
    raise nodes.SkipNode


def _display(translator: HTML5Translator, node: nodes.math_block) -> None:
    translator.body.append(f'<div class="equation">{convert(node.astext(), display="block")}</div>')
    raise nodes.SkipNode
