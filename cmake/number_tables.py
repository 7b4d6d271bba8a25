"""C++ tables of the shipped vehicles and scenarios. Why: C++ parses no TOML, and numbers must not be copied by hand."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

WORDS = {  # by the last part of the key: enumerators in C++
    "rotor.kind": {"variable-pitch": 0, "fixed-pitch": 1},  # firmware/core/vehicle.hpp
    "fault.kind": {  # sim/scenario.hpp
        "weak-rotor": 1,
        "stuck-rotor": 2,
        "dead-rotor": 3,
        "mocap-lost": 4,
        "mocap-frozen": 5,
        "gps-lost": 6,
    },
}


def numbers(table: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, float]]:
    for key, entry in table.items():
        path = prefix + key
        pieces = enumerate(entry) if isinstance(entry, list) else ((None, entry),)
        for i, piece in pieces:
            name = path if i is None else f"{path}.{i}"
            if isinstance(piece, dict):
                yield from numbers(piece, name + ".")
            elif isinstance(piece, (bool, int, float)):
                yield name, float(piece)
            elif (kind := ".".join(part for part in name.split(".") if not part.isdigit())) in WORDS:
                yield name, float(WORDS[kind][piece])


def table_of(file: Path) -> dict[str, Any]:
    """What a file says, and what the one beside it says that it is like."""
    table = tomllib.loads(file.read_text())
    return merged(table_of(file.with_name(f"{table.pop('like')}.toml")), table) if "like" in table else table


def merged(base: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    both = dict(base)
    for key, entry in changes.items():
        both[key] = merged(both[key], entry) if isinstance(entry, dict) and isinstance(both.get(key), dict) else entry
    return both


def main(word: str, out: Path, files: list[Path]) -> None:
    lines = [f"// made from *.toml: {word}(name, {{key, number}}...)"]
    for file in sorted(files):
        entries = ", ".join(f'{{"{key}", {number!r}}}' for key, number in numbers(table_of(file)))
        lines.append(f'{word}("{file.stem}", {entries})')
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]), [Path(name) for name in sys.argv[3:]])
