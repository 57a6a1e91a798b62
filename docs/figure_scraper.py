"""Sphinx-Gallery scraper for figures that functions of the report return."""

from typing import Any

from sphinx_gallery.scrapers import figure_rst, matplotlib_scraper


def saved_figure(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save the `figure` of an example, or its pyplot figures; return the reST that shows them."""
    figure = block_vars["example_globals"].pop("figure", None)
    if figure is None:
        return matplotlib_scraper(block, block_vars, gallery_conf)
    path = next(block_vars["image_path_iterator"])
    figure.savefig(path, dpi=110, bbox_inches="tight")
    return figure_rst([path], gallery_conf["src_dir"])
