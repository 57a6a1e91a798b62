"""Random changes of a file: of its bytes, of the values of a document, of the whole content."""

import copy
import json
import random

import yaml

# Replacements of a value of a document, as text.
SNIPPETS = (
    "1e300", "1.0e+300", "-1.0e+300", "1.0e-300", "0", "-1", "-0.0", ".nan", ".inf", "1e5000",
    "9" * 40, "9" * 5000, "0x" + "f" * 3000, "1:" * 900 + "1", "true", "null", "~", "''", "[]",
    "{}", "[/red]", "'[/red]'", "../../etc/passwd", "'\\0'", '"\\0"', '"\\x1b[31m"', "'=1+1'",
    "<script>alert(1)</script>", "$\\frac$", "x" * 5000, "'" + "/x" * 60_000 + "'", "[" * 2000,
    "[" * 40 + "]" * 40, "{a: " * 40 + "1" + "}" * 40, "&a [*a]", "*nothing",
    "!!python/name:os.system",
    "!!binary x", "!!timestamp 2020-13-45", "2020-13-45", "!!int x", "? [a]", "<<: 1", "2e7", "é",
    "[1, 2, 3]", "{v: 1.0e+9, src: 'd: x'}", "{v: -5, src: 'd: x'}", "{v: 0.001, src: 'd: x'}",
    "{v: [1, 2], src: 'd: x'}", "1.0e+3", "1.0e-3", "1.0e+6", "1.0e-6", "1000000", "17",
)  # fmt: skip
BOMB = "a: &a [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{new}: &{new} [{', '.join(['*' + old] * 9)}]\n"
    for old, new in zip("abcdefgh", "bcdefghi", strict=True)
)
MERGES = "a: &a {x: 1}\n" + "".join(
    f"{new}: &{new} {{<<: [{', '.join(['*' + old] * 9)}]}}\n"
    for old, new in zip("abcdefgh", "bcdefghi", strict=True)
)
WHOLE = (
    b"", b"\n", b"\xff\xfe\x00", b"\x00" * 100, b"\xef\xbb\xbf", b"---\n---\n", b"- " * 5000 + b"x",
    b"[" * 100_000, b'{"a":' * 100_000, b"{" * 5000, BOMB.encode(), MERGES.encode(),
    b"a: 1\na: 2\n",
    b"x" * 300_000, b"\x1b[31m", b"%YAML 9.9\n---\na: 1\n", b"extends: osb1\nextends: osb1\n",
    b"? " * 3000, b"- - " * 3000, b"'", b"#" * 10_000, b"a,b\n1,2\n" * 3,
)  # fmt: skip
BYTES = (b"\xff", b"\x00", b"\x1b[31m", b"\xc3", b"9" * 5000, b"[/red]", b"nan", b"inf", b"1e400",
         b",", b"\n", b"\t", b";", b'"', b"'", b":", b"-", b"*", b"&", b"{", b"[", b"\xe2\x80\xa8",
         b"../../x", b"=1+1", b"1e-320", b"D+99", b"0", b" ", b"-Infinity", b"*******", b"1e999",
         b"1D5", b"1d-400", b"1,5", b"--", b"+-1", b"..", b"E", b"0x10", b"1_000", b"\xd9\xa3",
         b"\xef\xbb\xbf", b"1" * 5000 + b"x", b" " * 999, b"\n" * 50, b"NPTS=",
         b"NPTS= 99999999999999999999, DT= 1e-300 SEC", b"DT= 0.0", b"DT= -1", b"DT= 1E400 SEC",
         b"UNITS OF CM/SEC2", b"VELOCITY", b"points of accel data equally spaced at 0 sec",
         b"Scale Factor      0(gal)/0", b"Sampling Freq(Hz) 1e400Hz",
         b"Scale Factor 1e300(gal)/1e-300", b"<html>", b"PK\x03\x04",
         b"version https://git-lfs", b"1e308", b"-1e308", b"\r")  # fmt: skip


def of_bytes(content: bytes, chance: random.Random) -> bytes:
    """Return a file with one to four of its places changed."""
    out = bytearray(content)
    for _ in range(chance.randint(1, 4)):
        place = chance.randrange(len(out) + 1)
        size = min(chance.choice((1, 1, 2, 8, 60, 500)), len(out) - place)
        kind = chance.randrange(7)
        if kind == 0 and place < len(out):
            out[place] ^= 1 << chance.randrange(8)
        elif kind == 1:
            out[place:place] = chance.choice(BYTES)
        elif kind == 2:
            del out[place : place + size]
        elif kind == 3:
            out[place:place] = out[place : place + size] * chance.choice((1, 2, 30))
        elif kind == 4:
            del out[place:]
        elif kind == 5:
            lines = bytes(out).split(b"\n")
            one, other = (chance.randrange(len(lines)) for _ in range(2))
            lines[one], lines[other] = lines[other], lines[one]
            out = bytearray(b"\n".join(lines))
        else:
            out[place : place + size] = chance.choice(BYTES)
    return bytes(out)


def of_structure(content: bytes, chance: random.Random, *, is_json: bool = False) -> bytes:
    """Return a document with one to three of its values changed, dropped or doubled."""
    tree = yaml.safe_load(content)
    for number in range(chance.randint(1, 3)):
        holders = [node for node in nodes_of(tree) if node]
        if not holders:
            break
        node = chance.choice(holders)
        key = chance.choice(list(node) if isinstance(node, dict) else range(len(node)))
        kind = chance.randrange(8)
        if kind == 0:
            del node[key]
        elif kind == 1 and isinstance(node, dict):
            node[chance.choice(("", "v", "x" * 300, "[/red]", "1", "colour"))] = node[key]
        elif kind == 2:
            node[key] = copy.deepcopy(chance.choice(holders))
        elif kind == 3 and isinstance(node[key], int | float):
            node[key] *= chance.choice((-1, 0, 1e-6, 0.1, 3, 10, 1e3, 1e6, 1e300))
        else:
            node[key] = f"@@{number}@@"
    text = json.dumps(tree) if is_json else yaml.safe_dump(tree, sort_keys=False)
    for number in range(3):
        snippet = chance.choice(SNIPPETS)
        for mark in (f'"@@{number}@@"', f"'@@{number}@@'", f"@@{number}@@"):
            text = text.replace(mark, snippet)
    return text.encode()


def nodes_of(tree: object) -> list[dict | list]:
    if not isinstance(tree, dict | list):
        return []
    inner = tree.values() if isinstance(tree, dict) else tree
    return [tree, *(node for item in inner for node in nodes_of(item))]


def mutant_of(content: bytes, suffix: str, chance: random.Random) -> bytes:
    """Return one mutant of a good file."""
    draw = chance.random()
    if draw < 0.05:
        return chance.choice(WHOLE)
    if draw < 0.65 and suffix in (".yaml", ".json"):
        return of_structure(content, chance, is_json=suffix == ".json")
    return of_bytes(content, chance)
