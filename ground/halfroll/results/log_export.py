"""A log's topics as tables that any tool reads: a CSV or a Parquet file each.

Why: spreadsheets, pandas and databases do not read ULog.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from halfroll.errors import InputError
from halfroll.results.log import Array, Log, Topic

FORMATS = ("csv", "parquet")


def export(log: Log, folder: Path, kind: str = "csv", names: Sequence[str] = ()) -> list[Path]:
    """Writes each topic, or those named, as FOLDER/TOPIC.csv or .parquet; the files' names.

    Columns: t_s, then each field, FIELD.0, FIELD.1, … for arrays. Numbers are read back bit for bit. Raises InputError
    for a topic that is not there, for another kind, and where Parquet's library is missing; OSError.
    """
    if kind not in FORMATS:
        raise InputError(f"format {kind!r} is not known; give one of {', '.join(FORMATS)}")
    chosen = [log[name] for name in names] or [log[name] for name in sorted(log) if len(log[name])]
    write = _write_csv if kind == "csv" else _parquet_writer()
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for topic in chosen:
        written.append(folder / f"{topic.name}.{kind}")
        write(written[-1], dict(columns(topic)))
    return written


def columns(topic: Topic) -> Iterator[tuple[str, Array]]:
    yield "t_s", topic.t
    for name, samples in topic.fields.items():
        if samples.ndim == 1:
            yield name, samples
        else:
            yield from ((f"{name}.{i}", column) for i, column in enumerate(samples.T))


def _write_csv(path: Path, table: dict[str, Array]) -> None:
    texts = [_shortest(column) for column in table.values()]
    with path.open("w", encoding="utf-8") as file:
        file.write(",".join(table) + "\n")
        file.writelines(",".join(row) + "\n" for row in zip(*texts, strict=True))


def _shortest(column: Array) -> list[str]:
    """Each number in the fewest digits that give back its bits."""
    if column.dtype.kind == "f":
        return [np.format_float_positional(x, unique=True, trim="-") if np.isfinite(x) else str(x) for x in column]
    return [str(x) for x in column.tolist()]


def _parquet_writer() -> Callable[[Path, dict[str, Array]], None]:
    try:
        import pyarrow
        from pyarrow import parquet
    except ModuleNotFoundError:
        raise InputError("Parquet wants pyarrow, which is not installed: `pip install pyarrow`, or take csv") from None

    def write(path: Path, table: dict[str, Array]) -> None:
        parquet.write_table(pyarrow.table({name: pyarrow.array(column) for name, column in table.items()}), path)

    return write
