"""Read, measure and scale the motions of a study, and store them in one parquet table."""

import json
import logging
import math
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from skewbridge.errors import InputError, raise_all
from skewbridge.files.digests import digest_of, file_states, layer_digest, provenance
from skewbridge.files.tables import read_frame, write_frame
from skewbridge.files.text import read_json, write_text
from skewbridge.motions import intensity, levels, p695, read
from skewbridge.motions.folder import INDEX_NAME, IndexEntry, files_below, list_motions, read_index
from skewbridge.motions.formats import Stated
from skewbridge.motions.record import NUMBER_FIELDS, TEXT_FIELDS, GroundMotion, SuiteMotion, Vector

logger = logging.getLogger(__name__)


def read_entry(entry: IndexEntry) -> GroundMotion:
    """Read or generate one listed motion; the index overrides the file headers.

    Raises `InputError` for unreadable files, a digest that differs from the index, or a motion that
    is named as the WAHO record but is a different one.
    """
    number, suite = entry.made_from_number, entry.made_from_suite
    if number is None:
        trace_1, trace_2 = (read.read_trace(path, stated) for path, stated in entry.components)
        motion = read.join_traces(trace_1, trace_2, motion_id=entry.motion_id)
    elif suite in p695.SUITES:
        motion = p695.read_record(suite, number)
    else:  # here: a suite of files does not need the stochastic model
        from skewbridge.motions.synthesis import made_motion

        motion = made_motion(number, suite)
    if entry.sha256 and entry.sha256 != motion.sha256:
        values, cause = "its values", "different libraries"
        if motion.files:
            values, cause = f"the files {' and '.join(motion.files)}", "changed files"
        digests = f"sha256 {motion.sha256[:12]}..., the index has {entry.sha256[:12]}..."
        advice = f"{cause}? run `skewbridge motions check --write` to accept them"
        text = f"motion {entry.motion_id}: {values} have {digests}: {advice}"
        raise InputError(text, motion_id=entry.motion_id)
    motion = replace(motion, motion_id=entry.motion_id, **entry.metadata)
    read.refuse_false_waho(motion)
    return motion


def read_pair(first: Path, second: Path, stated: Stated | None = None) -> GroundMotion:
    """Read the files of a motion (`read_motion`), or their row in the `index.csv` beside them.

    Files in the opposite order of the row exchange the components, and the digest is not compared.
    ``stated`` is for files without a row.
    """
    files = [first.resolve(), second.resolve()]
    for entry in _listed_beside(first):
        listed = [path.resolve() for path, _ in entry.components]
        if listed == files:
            return read_entry(entry)
        if listed[::-1] == files:
            changes: dict[str, Any] = {"components": entry.components[::-1], "sha256": ""}
            azimuths = {"azimuth_1_deg": entry.azimuth_2_deg, "azimuth_2_deg": entry.azimuth_1_deg}
            return read_entry(entry.model_copy(update=changes | azimuths))
    return read.read_motion(first, second, stated)


def read_components(
    files: list[Path], stated: Stated
) -> tuple[str, float, list[Vector], tuple[str, ...]]:
    """Return name, time step (s), components (m/s2) and messages of one file or a pair.

    Time step, unit and channel are ``stated``, unless the `index.csv` beside the files lists them.
    """
    if INDEX_NAME in (file.name for file in files):
        raise InputError(f"{INDEX_NAME} lists motions: give the files of one of them")
    if len(files) == 1:
        parts = [part for entry in _listed_beside(files[0]) for part in entry.components]
        listed = [row for path, row in parts if path.resolve() == files[0].resolve()] or [stated]
        if len({row.channel for row in listed}) > 1:
            text = f"{files[0].name} has two channels in {INDEX_NAME}: give the file twice"
            raise InputError(text, file=str(files[0]))
        trace = read.read_trace(files[0], listed[0])
        return files[0].stem, trace.dt_s, [trace.accel_mps2], trace.messages
    first, second = files
    motion = read_pair(first, second, stated)
    return motion.motion_id, motion.dt_s, list(motion.components), motion.messages


def _listed_beside(file: Path) -> list[IndexEntry]:
    index = file.parent / INDEX_NAME
    return read_index(index) if index.is_file() else []


def read_entries(entries: Iterable[IndexEntry]) -> list[GroundMotion]:
    """Read listed motions; a single `InputError` names all faulty motions."""
    motions: list[GroundMotion] = []
    faults: list[InputError] = []
    for entry in entries:
        try:
            motions.append(read_entry(entry))
        except InputError as error:
            faults.append(error)
    raise_all(faults)
    return motions


def prepare_suite(
    folder: Path,  # folder with an `index.csv`, or with files that are paired by their names
    *,
    count: int | None = None,  # number of motions, starting with the first; None: all
    t1_s: float,  # conditioning period of the bridge, for Sa(T1) and Sa_avg
    #: Sa_avg of the scaled motions; a factor in the index is kept.
    bands_g: levels.Bands = (levels.LEVEL_RANGE_G,),
    first_g: levels.Bands | None = None,  # other bands of the first block
    shaking_s: float | None = None,  # length of the strongest part to keep; None: the whole motion
) -> pd.DataFrame:
    """Read, measure and scale the motions of a folder.

    Returns one row per motion in suite order, with metadata, scale, npts and messages (JSON). The
    intensity measures and accelerations (arrays accel_1_mps2, accel_2_mps2) are unscaled.
    """
    entries, stored = _entries_to_read(folder, count)
    motions = read_entries(entries)
    if shaking_s is not None:
        motions = [intensity.strongest_part(motion, shaking_s) for motion in motions]
    measures = [intensity.motion_measures(motion, t1_s) for motion in motions]
    level_g = [row[levels.LEVEL_MEASURE] for row in measures]
    computed = levels.block_factors(level_g, bands_g, first_g)
    low, high = levels.FACTOR_LIMITS
    rows: list[dict[str, Any]] = []
    names: dict[tuple[object, ...], str] = {}
    for motion, given, factor, measured in zip(motions, stored, computed, measures, strict=False):
        # six digits, which do not depend on the processor
        scale = float(f"{factor:.6g}") if math.isnan(given) else given
        messages = list(motion.messages)
        # one record may serve several levels of a selection, with other factors in the index
        if earlier := read.earlier_record(names, motion.motion_id, motion.components, str(given)):
            messages.append(f"the samples of motion {earlier}: does one record count twice?")
        note = f"scale factor {scale:.3g} is outside {low:g} to {high:g}"
        for message in (*messages, *([] if low <= scale <= high else [note])):
            logger.warning("motion %s: %s", motion.motion_id, message)
        row: dict[str, Any] = {"scale": scale, "npts": motion.npts}
        row |= {name: getattr(motion, name) for name in (*TEXT_FIELDS, *NUMBER_FIELDS)}
        row |= measured | {name: getattr(motion, name) for name in ("accel_1_mps2", "accel_2_mps2")}
        rows.append(row | {"messages": json.dumps(messages)})
    return pd.DataFrame(rows)


@dataclass(frozen=True, slots=True)
class SuiteSource:
    """Name, folder and number of motions of one suite of a study."""

    name: str
    folder: Path
    count: int | None  # number of motions used; None: all
    note: str = ""  # follows the source of its motions


def suite_sources(motions: levels.MotionsConfig) -> list[SuiteSource]:
    """Return the suites of a study in the order of the configuration.

    The recorded suites of `p695` are replaced by the first shipped suite if their package is not
    installed. They and all suites after the first may have fewer motions than `motions.count`.
    Raises `InputError` if such a suite has no motions or names are repeated.
    """
    default, *other_suites = levels.SHIPPED_SUITES
    available = {name: (name, levels.SHIPPED_FOLDER / name) for name in other_suites}
    available[default] = (default, levels.SHIPPED_FOLDER)
    available |= {name: (name, Path(name)) for name in p695.SUITES}
    sources: list[SuiteSource] = []
    folders = motions.suites if motions.folder is None else (motions.folder,)
    absent = [] if p695.package_folder() else [name for name in folders if name in p695.SUITES]
    if absent:
        available[absent[0]] = (default, levels.SHIPPED_FOLDER)
        logger.warning("%s", p695.missing_text(absent[0], f"the synthetic suite {default} is used"))
    replaced = absent if default in folders else absent[1:]
    available[str(levels.SHIPPED_FOLDER)] = available[default]
    for entry in (name for name in folders if name not in replaced):
        name, folder = available.get(entry, (Path(entry).name, Path(entry)))
        count = motions.count
        if (sources or entry in p695.SUITES) and count is not None:
            count = min(count, len(list_motions(folder)))
        sources.append(SuiteSource(name, folder, count, p695.REPLACED if entry in absent else ""))
    names = [source.name for source in sources]
    if len(set(names)) < len(names):
        raise InputError(f"motions.suites must name different suites, got {', '.join(names)}")
    return sources


def prepare_suites(
    motions: levels.MotionsConfig, *, t1_s: float, medians_g: Sequence[float] = ()
) -> pd.DataFrame:
    """Return the rows of all suites with the columns `suite` and `number` (position from 0).

    With `motions.bands`, levels are around ``medians_g``. If these are from trial runs, the first
    block of each suite keeps the levels of these runs.
    """
    bands: dict[str, Any] = {"bands_g": levels.bands_around(motions, medians_g)}
    bands["first_g"] = (motions.level_range_g,) if levels.has_pilot(motions) else None
    prepared = partial(prepare_suite, t1_s=t1_s, shaking_s=motions.shaking_s, **bands)
    tables: list[pd.DataFrame] = []
    for source in suite_sources(motions):
        table = prepared(source.folder, count=source.count)
        table["source"] += f"; {source.note}" if source.note else ""
        tables.append(table.assign(suite=source.name, number=range(len(table))))
    table = pd.concat(tables, ignore_index=True)
    twice = table["motion_id"][table["motion_id"].duplicated()]
    if len(twice):
        raise InputError(f"motion {twice.iloc[0]} is in two suites of motions.suites: rename one")
    return table


def striped(suite: pd.DataFrame, stripes_g: Sequence[float]) -> pd.DataFrame:
    """Return one row per stripe and motion whose scale factor is within the limits.

    Rows are those of `prepare_suite` with a new `scale` and the column `stripe_g`; they are sorted
    by stripe. Raises `InputError` if no motion reaches a stripe.
    """
    low, high = levels.FACTOR_LIMITS
    level_g = suite[levels.LEVEL_MEASURE]
    stripes = [suite.assign(scale=g / level_g, stripe_g=float(g)) for g in stripes_g]
    all_rows = pd.concat(stripes, ignore_index=True)
    table = all_rows[all_rows["scale"].between(low, high)].reset_index(drop=True)
    if table.empty:
        text = f"no motion reaches a stripe of {list(stripes_g)} g with a factor of {low} to {high}"
        raise InputError(f"{text}: change motions.stripes_g or the suite")
    if left_out := len(all_rows) - len(table):
        text = "%d of %d scaled motions are left out: their factor is outside %g to %g"
        logger.warning(text, left_out, len(all_rows), low, high)
    return table


def _entries_to_read(folder: Path, count: int | None) -> tuple[list[IndexEntry], list[float]]:
    """Return the motions to read, and the factors of the first `count` in the index (or nan).

    A computed factor must not depend on the count, so full blocks of `BLOCK` motions are read.
    """
    entries = list_motions(folder)
    n_read = len(entries) if count is None else count
    if not 1 <= n_read <= len(entries):
        text = f"motions.count = {n_read}, but {folder} has {len(entries)} motions: reduce it"
        raise InputError(f"{text}, or design.most", folder=str(folder))
    stored = [entry.scale for entry in entries[:n_read]]
    compute = any(map(math.isnan, stored))
    return entries[: math.ceil(n_read / levels.BLOCK) * levels.BLOCK if compute else n_read], stored


def content_digest(folder: Path, count: int | None, cache: Path | None) -> str:
    """Return the digest of the index entries and files that `prepare_suite` uses.

    Other files and file times do not affect it. If the file `cache` has a digest for the same
    arguments, file names, sizes, times and reader sources, that digest is returned. Otherwise the
    motions with files are read, and a faulty one raises `InputError`.
    """
    readers = layer_digest(("errors.py", "units.py", "files", "motions"))
    state = digest_of(str(folder.resolve()), count, readers, file_states(files_below(folder)))
    cached: Any = None
    with suppress(InputError):
        cached = None if cache is None else read_json(cache)
    if isinstance(cached, dict) and cached.get("state") == state:
        return cached["digest"]
    entries, stored = _entries_to_read(folder, count)
    read_entries(entry for entry in entries if entry.components)  # not the generated ones
    parts: list[object] = [len(stored)]
    if str(folder) in p695.SUITES:
        parts.append(read.files_digest(*files_below(folder)))
    for entry in entries:
        files = [(path.relative_to(folder).as_posix(), stated) for path, stated in entry.components]
        digest = read.files_digest(*(path for path, _ in entry.components))
        parts.append((entry.model_dump(exclude={"components"}), files, digest))
    digest = digest_of(*parts)
    if cache is not None:
        write_text(cache, json.dumps({"state": state, "digest": digest}))
    return digest


def write_suite(suite: pd.DataFrame, path: Path) -> None:
    """Write the table of `prepare_suite` as parquet."""
    write_frame(suite, path, provenance())


def read_suite(path: Path) -> list[SuiteMotion]:
    """Return the motions of a table written by `write_suite`, in suite order."""
    motions: list[SuiteMotion] = []
    for row in read_frame(path).to_dict("records"):
        fields: dict[str, Any] = {name: str(row[name]) for name in TEXT_FIELDS}
        fields |= {name: float(row[name]) for name in NUMBER_FIELDS}
        fields |= {name: row[name] for name in ("accel_1_mps2", "accel_2_mps2")}
        motion = GroundMotion(**fields, messages=tuple(json.loads(row["messages"])))
        scale, measures = float(row["scale"]), {n: float(row[n]) for n in intensity.IM_COLUMNS}
        scaled = intensity.scaled_measures(measures, scale)
        place: Any = {"suite": str(row.get("suite", "")), "number": int(row.get("number", 0))}
        motions.append(SuiteMotion(motion=motion, scale=scale, measures=scaled, **place))
    return motions
