"""The documentation site is built without a warning."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_the_site_is_built_without_a_warning(tmp_path: Path) -> None:
    """Unknown pages in a toctree, pages in none, links and docstrings that fail are warnings."""
    command = [sys.executable, "-m", "sphinx", "--quiet", "--fail-on-warning", "--keep-going"]
    command += ["-c", "docs", "-d", str(tmp_path / "d"), ".", str(tmp_path / "s")]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "s/docs/theory/contact.html").read_text()
    assert "<math" in page
    site = tmp_path / "s/docs"
    assert "skewbridge motions check" in (site / "reference/commands.html").read_text()
    assert "column_drift_ratio" in (site / "reference/columns.html").read_text()
    assert "median of column failure" in (site / "theory/effects_by_suite.html").read_text()
    assert "https://" not in "".join(
        line for line in page.splitlines() if "<script" in line or "stylesheet" in line
    )
