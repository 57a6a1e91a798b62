"""Work on many variants, pairs or states spread over processes."""

from collections.abc import Callable, Iterable
from itertools import chain, islice

from joblib import Parallel, delayed

# ASSUME a process takes about a second to start, and an item some tenths: fewer are no gain
_WORTH_PROCESSES = 24


def spread[Item, Found](
    function: Callable[[Item], Found],
    items: Iterable[Item],
    jobs: int,
    *,
    least: int = _WORTH_PROCESSES,
) -> list[Found]:
    """Return the function of each item, in their order.

    Args:
        function: What is called; it and the items go to other processes.
        items: Its arguments.
        jobs: Processes; with one, or with few items, everything runs in this one.
        least: Items that are worth other processes.
    """
    rest = iter(items)
    first = list(islice(rest, least))
    if jobs == 1 or len(first) < least:
        return [function(item) for item in chain(first, rest)]
    return list(Parallel(n_jobs=jobs)(delayed(function)(item) for item in chain(first, rest)))
