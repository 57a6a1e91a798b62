"""Draw the rules of the workflow: `snakemake --rulegraph | python docs/rule_graph.py FILE.svg`."""

import re
import sys
from graphlib import TopologicalSorter
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure


def draw(dot: str, output: Path) -> None:
    """Draw the rules of a DOT graph from top to bottom, each below all rules whose output it reads.

    Arrows that a longer path makes redundant are omitted.
    """
    names = dict(re.findall(r'^\s*(\d+)\[label = "(\w+)', dot, re.M))
    reads: dict[str, set[str]] = {name: set() for name in sorted(names.values())}
    for start, end in re.findall(r"^\s*(\d+) -> (\d+)$", dot, re.M):
        reads[names[end]].add(names[start])
    step: dict[str, int] = {}
    earlier: dict[str, set[str]] = {}
    for rule in TopologicalSorter(reads).static_order():
        step[rule] = 1 + max((step[each] for each in reads[rule]), default=-1)
        earlier[rule] = reads[rule].union(*(earlier[each] for each in reads[rule]))
    rows = {each: [rule for rule in reads if step[rule] == each] for each in step.values()}
    position = {rule: (rows[step[rule]].index(rule), -step[rule]) for rule in reads}
    mpl.rcParams |= {"svg.fonttype": "none", "svg.hashsalt": "rules"}
    figure = Figure(figsize=(4, 6))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_xlim(-0.5, max(map(len, rows.values())) - 0.5)
    axes.set_ylim(-max(rows) - 0.5, 0.5)
    axes.axis("off")
    arrow = {"arrowstyle": "->", "color": "0.6", "shrinkA": 12, "shrinkB": 18}
    for end, starts in reads.items():
        for start in sorted(starts - set().union(*(earlier[each] for each in starts))):
            axes.annotate("", position[end], position[start], arrowprops=arrow)
    box = {"boxstyle": "round", "facecolor": "white", "edgecolor": "0.3"}
    for rule in reads:
        axes.text(*position[rule], rule, ha="center", va="center", fontsize=8, bbox=box)
    figure.savefig(output, metadata={"Date": None})


if __name__ == "__main__":
    draw(sys.stdin.read(), Path(sys.argv[1]))
