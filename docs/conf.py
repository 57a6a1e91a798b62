"""Sphinx configuration of the documentation site: `make docs` builds it into docs/_build/html.

The source folder of Sphinx is the root of the repository. So README, CONTRIBUTING and the page of
configuration keys are pages of the site, and links work on the site and in a code browser.
"""

import shutil
import sys
from collections.abc import Iterator
from importlib.metadata import version as version_of
from pathlib import Path

import typer
from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator
from typer.core import TyperCommand, TyperGroup
from typer.main import get_command

from skewbridge.cli import build_app
from skewbridge.report.methods import REFERENCES
from skewbridge.study.processes import hush_exit_message

sys.path.insert(0, str(Path(__file__).parent))

from reference_pages import columns_page
from suite_table import stored_page

hush_exit_message()

HERE = Path(__file__).parent

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
exclude_patterns = [
    "docs/_build/**",
    "docs/examples/**",
    "**.ipynb",
    "docs/gallery/sg_execution_times.rst",
]

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
]
myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3

default_role = "code"  # docstrings quote names with single backticks
toc_object_entries = False
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_default_options = {"members": True}
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True

copybutton_prompt_text = "$ "

sphinx_gallery_conf = {
    "examples_dirs": ["docs/examples"],
    "gallery_dirs": ["docs/gallery"],
    "backreferences_dir": "docs/gallery/backreferences",
    "image_scrapers": ("figure_scraper.saved_figure",),
    "abort_on_example_error": True,
    "ignore_repr_types": "matplotlib",
    "remove_config_comments": True,
    "download_all_examples": False,
    "show_signature": False,
    "show_memory": False,
    "min_reported_time": 1_000_000,
    "matplotlib_animations": False,
    "write_computation_times": False,
}

html_theme = "furo"
html_title = "skewbridge"
templates_path = ["_templates"]
html_static_path = ["_static"]
html_css_files = ["equations.css"]
# The start page is in docs/; index.html of the site redirects to it.
html_extra_path = ["example_report"]
html_additional_pages = {"index": "start.html"}
html_copy_source = False
html_math_renderer = "mathml"


COMMANDS_HEAD = """\
# Commands

Results go to stdout (with `--json` as one JSON object; `--units us` shows tables in kip, in and
ft), messages to stderr. Exit codes: 0 success, 1 failed analysis or check, 2 bad input.
"""


def setup(app: Sphinx) -> None:
    """Render equations as MathML (the site needs no network) and write the generated pages."""
    app.add_html_math_renderer("mathml", (_inline, None), (_display, None))
    commands = COMMANDS_HEAD + "".join(_help(get_command(build_app())))
    for name, text in {
        "reference/commands.md": commands,
        "reference/columns.md": columns_page(),
        "theory/effects_by_suite.md": stored_page(),
        "theory/references.md": _references(),
    }.items():
        (HERE / name).write_text(text, encoding="utf-8")
    report = HERE / "example_report"
    report.mkdir(exist_ok=True)
    if (finished := HERE.parent / "results" / "report.html").is_file():  # of the default study
        shutil.copy(finished, report)
    else:
        build_app()(["demo", "--out", str(report), "--json"], standalone_mode=False)


def _references() -> str:
    """Return the Markdown page of works cited in the methods text and on pages."""
    cited = (HERE / "data" / "references.txt").read_text(encoding="utf-8").splitlines()
    return "# References\n\n" + "".join(
        f"- {work}\n" for work in sorted({*REFERENCES.values(), *cited})
    )


def _help(command: TyperGroup | TyperCommand, parent: typer.Context | None = None) -> Iterator[str]:
    """Yield the help of every command as Markdown, in the order of command groups."""
    for word in command.commands if isinstance(command, TyperGroup) else ():
        context = typer.Context(command, parent=parent, info_name=command.name or "skewbridge")
        name, inner, _ = command.resolve_command(context, [word])
        called = typer.Context(inner, parent=context, info_name=name)
        if isinstance(inner, TyperGroup):
            yield from _help(inner, context)
        else:
            yield f"\n## {called.command_path}\n\n```text\n{inner.get_help(called)}\n```\n"


def _inline(translator: HTML5Translator, node: nodes.math) -> None:
    translator.body.append(convert(node.astext()))
    raise nodes.SkipNode


def _display(translator: HTML5Translator, node: nodes.math_block) -> None:
    translator.body.append(f'<div class="equation">{convert(node.astext(), display="block")}</div>')
    raise nodes.SkipNode
