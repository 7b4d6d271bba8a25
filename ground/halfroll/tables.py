"""TOML files of checked numbers, with overrides by dotted key. Why: vehicles and scenarios are read, changed, refused
and handed to the simulator in one way."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationError

from halfroll.errors import InputError
from halfroll.reading import parse_toml, read_text


class Table(BaseModel):
    """A frozen table that knows all its keys."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


def numbers(table: Mapping[str, Any], words: Mapping[str, float], prefix: str = "") -> Iterator[tuple[str, float]]:
    """Every number by its dotted key ("rotor.lag_s", "inertia_kg_m2.0"), texts as `words` has them, others left out."""
    for key, entry in table.items():
        pieces = enumerate(entry) if isinstance(entry, (list, tuple)) else ((None, entry),)
        for i, piece in pieces:
            path = prefix + key + ("" if i is None else f".{i}")
            if isinstance(piece, Mapping):
                yield from numbers(piece, words, path + ".")
            elif isinstance(piece, str):
                if piece in words and key == "kind":
                    yield path, words[piece]
            elif isinstance(piece, (bool, int, float)):
                yield path, float(piece)


def shipped(folder: Path) -> list[str]:
    """Names of the files that come with halfroll, sorted."""
    return sorted(file.stem for file in folder.glob("*.toml"))


def read(name_or_path: str | Path, folder: Path, what: str, error: type[InputError]) -> dict[str, Any]:
    """A shipped table by name, or any .toml file; what one that is `like` a shipped one does not say is as there.
    Raises `error`, which says what there is."""
    table = as_written(name_or_path, folder, what, error)
    if "like" not in table:
        return table
    base = table.pop("like")
    if base not in shipped(folder):
        known = ", ".join(shipped(folder))
        raise error(f"{what} {name_or_path} is like {base!r}, which is not shipped; like is one of {known}")
    return merged(read(base, folder, what, error), table)


def merged(base: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """`base` with the entries of `changes` in their place, table by table."""
    both = dict(base)
    for key, entry in changes.items():
        before = both.get(key)
        both[key] = merged(before, entry) if isinstance(before, Mapping) and isinstance(entry, Mapping) else entry
    return both


def as_written(name_or_path: str | Path, folder: Path, what: str, error: type[InputError]) -> dict[str, Any]:
    file = Path(name_or_path)
    if file.suffix != ".toml":
        file = folder / f"{name_or_path}.toml"
        if str(name_or_path) not in shipped(folder):
            known = ", ".join(shipped(folder))
            raise error(f"no {what} is called {name_or_path!s}; shipped are {known}; or give the path of a .toml file")
    try:
        return parse_toml(read_text(file))
    except OSError as failure:
        raise error(f"{what} file {file}: {failure.strerror or failure}; check the path") from None
    except ValueError as failure:
        raise error(f"{what} file {file} is not TOML: {failure}") from None


def override(table: dict[str, Any], key: str, entry: str | float, unknown: InputError, made: tuple[str, ...]) -> None:
    """Change one number by its dotted key; tables named in `made` need not be there. Raises `unknown`."""
    *path, last = key.split(".")
    inner: Any = table
    for step in path:
        outer = inner
        if isinstance(inner, list) and step.isdigit() and int(step) < len(inner):
            inner = inner[int(step)]
        else:
            inner = inner.get(step) if isinstance(inner, dict) else None
        if inner is None and step in made and isinstance(outer, dict):
            inner = outer.setdefault(step, {})
    new: str | float = _number_or_text(entry)
    if isinstance(inner, list) and last.isdigit() and int(last) < len(inner):
        inner[int(last)] = new
    elif isinstance(inner, dict) and not isinstance(inner.get(last), (dict, list)):
        inner[last] = new  # a wrong name is refused by the model, with the names it knows
    else:
        raise unknown


def _number_or_text(entry: str | float) -> str | float:
    try:
        return float(entry)
    except ValueError:
        return entry


def sentence(error: ValidationError, example: str) -> str:
    """The first thing that is wrong; `example` is a file that has every key."""
    first = error.errors(include_url=False)[0]
    key = ".".join(str(step) for step in first["loc"])
    if first["type"] == "value_error":  # our own words
        return str(first["ctx"]["error"])
    if first["type"] == "missing":
        return f"{key} is missing; add it to the file"
    if first["type"] == "extra_forbidden":
        return f"{key} is not a known key; check its spelling ({example} has them all)"
    return f"{key} is {first['input']!r}: {first['msg'][0].lower()}{first['msg'][1:]}"
