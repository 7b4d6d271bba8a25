"""Turn vehicles/*.toml into a C++ table of (key, number), so that halfroll-sitl knows the shipped vehicles.

Why: the TOML files are the only place of these numbers, and C++ parses no TOML. A key is the dotted path
("rotor.thrust_max_N", "inertia_kg_m2.0"); a rotor kind becomes its enumerator.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROTOR_KINDS = {"variable-pitch": 0, "fixed-pitch": 1}


def numbers(table: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, float]]:
    for key, entry in table.items():
        path = prefix + key
        if isinstance(entry, dict):
            yield from numbers(entry, path + ".")
        elif isinstance(entry, list):
            yield from ((f"{path}.{i}", float(x)) for i, x in enumerate(entry))
        elif path == "rotor.kind":
            yield path, ROTOR_KINDS[entry]
        elif isinstance(entry, (int, float)):
            yield path, float(entry)


def main(out: Path, files: list[Path]) -> None:
    lines = ["// made from ground/halfroll/vehicles/*.toml: VEHICLE(name, {key, number}...)"]
    for file in sorted(files):
        entries = ", ".join(f'{{"{key}", {number!r}}}' for key, number in numbers(tomllib.loads(file.read_text())))
        lines.append(f'VEHICLE("{file.stem}", {entries})')
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]), [Path(name) for name in sys.argv[2:]])
