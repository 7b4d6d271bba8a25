"""The archive of a campaign: a folder of Parquet parts and what they are of.

Why: results are kept as they come, in bounded memory, and whatever stops a campaign, no run is lost that was kept and
none is kept twice. A part holds a fixed range of runs, in order, so its bytes do not depend on who flew them.

    DIR/campaign.json              space, seed, runs
    DIR/runs/part-000000.parquet   runs 0 to 99, complete
    DIR/unfinished/000001.parquet  what there is of runs 100 to 199
"""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from halfroll.campaign.judgement import SUMMED_UP
from halfroll.campaign.space import Space, SpaceError
from halfroll.errors import InputError
from halfroll.reading import parse_json, read_text

if TYPE_CHECKING:
    import pyarrow as pa

PART_RUNS = 100
LONG_COLUMNS = ("waypoint_miss_m", "commands_sha256")  # that no statistic of all runs needs


def parquet() -> Any:
    """pyarrow.parquet. Raises InputError where it is not installed."""
    try:
        import pyarrow.parquet
    except ModuleNotFoundError:
        raise InputError(
            "campaigns are kept by pyarrow, which is not installed: pip install 'halfroll[campaign]'"
        ) from None
    return pyarrow.parquet


def schema_of(space: Space) -> pa.Schema:
    """Columns of a run: number, seed, what varies, what came of it."""
    import pyarrow as pa

    varied = [(key, pa.float64() if axis.is_numeric else pa.string()) for key, axis in space.axes.items()]
    figures = [(name, pa.float64()) for name in SUMMED_UP]
    return pa.schema(
        [
            ("run", pa.int64()),
            ("seed", pa.int64()),
            *varied,
            ("succeeded", pa.bool_()),
            ("why", pa.string()),
            *figures,
            ("waypoint_miss_m", pa.list_(pa.float64())),
            ("commands_sha256", pa.binary(32)),
        ]
    )


@dataclass(frozen=True)
class _Identity:
    """What the runs of a folder are functions of."""

    space: str  # fingerprint
    seed: int
    table_runs: int | None  # of samplings whose run i depends on how many there are

    @classmethod
    def of(cls, space: Space) -> _Identity:
        told = space.told
        return cls(space.fingerprint, told.seed, told.runs if told.sampling == "lhs" else None)


class Archive:
    """Open one with `open_archive`; `keep` every row once; `close` when flying ends, however it ends."""

    def __init__(self, folder: Path, space: Space) -> None:
        self.folder, self._space = folder, space
        self._schema = schema_of(space)
        self._pending: dict[int, dict[int, dict[str, Any]]] = {}  # part -> run -> row
        self._complete = {_number_of(file) for file in self._runs.glob("part-*.parquet")}
        for file in sorted(self._unfinished.glob("*.parquet")):
            part = int(file.stem)
            if part in self._complete:  # it was completed just before the end
                file.unlink()
            else:
                rows = _read(file).to_pylist()
                self._pending[part] = {row["run"]: row for row in rows}

    @property
    def _runs(self) -> Path:
        return self.folder / "runs"

    @property
    def _unfinished(self) -> Path:
        return self.folder / "unfinished"

    @property
    def kept(self) -> int:
        """How many runs there are."""
        return len(self._complete) * PART_RUNS + sum(len(rows) for rows in self._pending.values())

    def missing(self, runs: int) -> Iterator[int]:
        """Of the first `runs`, those that are not kept, in order."""
        for part in range(-(-runs // PART_RUNS)):
            if part not in self._complete:
                known = self._pending.get(part, {})
                first = part * PART_RUNS
                yield from (i for i in range(first, min(first + PART_RUNS, runs)) if i not in known)

    def keep(self, row: dict[str, Any]) -> None:
        """Raises InputError for a run that is there: nothing is flown twice."""
        part = row["run"] // PART_RUNS
        rows = self._pending.setdefault(part, {})
        if part in self._complete or row["run"] in rows:
            raise InputError(f"run {row['run']} is kept already; two campaigns write to {self.folder}")
        rows[row["run"]] = row
        if len(rows) == PART_RUNS:
            self._write(self._runs / f"part-{part:06d}.parquet", rows)
            self._complete.add(part)
            del self._pending[part]
            with contextlib.suppress(FileNotFoundError):
                (self._unfinished / f"{part:06d}.parquet").unlink()

    def flush(self) -> None:
        """What is complete in no part is kept beside."""
        for part, rows in self._pending.items():
            self._write(self._unfinished / f"{part:06d}.parquet", rows)

    def cut(self, runs: int) -> None:
        """Forget all beyond the first `runs`, a whole number of parts."""
        for part in [p for p in (*self._complete, *self._pending) if p * PART_RUNS >= runs]:
            self._complete.discard(part)
            self._pending.pop(part, None)
            for file in (self._runs / f"part-{part:06d}.parquet", self._unfinished / f"{part:06d}.parquet"):
                with contextlib.suppress(FileNotFoundError):
                    file.unlink()

    def _write(self, file: Path, rows: dict[int, dict[str, Any]]) -> None:
        import pyarrow as pa

        file.parent.mkdir(exist_ok=True)
        columns = {name: [rows[run][name] for run in sorted(rows)] for name in self._schema.names}
        rough = file.with_suffix(".rough")
        try:
            parquet().write_table(pa.table(columns, self._schema), rough, compression="zstd")
            rough.replace(file)  # there whole, or not at all
        except OSError as error:
            with contextlib.suppress(OSError):
                rough.unlink()
            raise InputError(
                f"{file} cannot be written ({os.strerror(error.errno) if error.errno else error}); what was kept "
                "before is whole: make room, and the same command goes on"
            ) from error

    def tables(self) -> Iterator[pa.Table]:
        """All runs, in order, a part at a time."""
        for file in part_files(self.folder):
            yield _read(file, schema=self._schema)


def open_archive(folder: Path, space: Space) -> Archive:
    """A new one, or the one that is there, to go on with. Raises SpaceError where another campaign's is."""
    parquet()
    about, identity = folder / "campaign.json", vars(_Identity.of(space))
    if about.is_file():
        known = _identity_in(about)
        for key, what in (
            ("space", "another space"),
            ("seed", "another seed"),
            ("table_runs", "another number of runs"),
        ):
            if known[key] != identity[key]:
                raise SpaceError(
                    f"{folder} holds a campaign with {what}; give another folder with -o, or remove this one"
                )
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "runs").mkdir(exist_ok=True)
    told = {
        "name": space.told.name,
        "identity": identity,
        "part_runs": PART_RUNS,
        "space": space.told.model_dump(mode="json", exclude_none=True),
    }
    rough = about.with_suffix(".rough")
    rough.write_text(json.dumps(told, indent=1) + "\n")
    rough.replace(about)
    return Archive(folder, space)


def _identity_in(about: Path) -> dict[str, Any]:
    try:
        identity = parse_json(read_text(about))["identity"]
        return {key: identity[key] for key in _Identity.__annotations__}
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise SpaceError(
            f"{about} does not say what campaign it is of ({error}); give another folder with -o"
        ) from None


def part_files(folder: Path) -> list[Path]:
    """Of a campaign's folder, all that holds runs, in order of the runs."""
    files = [*folder.glob("runs/part-*.parquet"), *folder.glob("unfinished/*.parquet")]
    return sorted(files, key=lambda file: file.stem.removeprefix("part-"))


def _read(file: Path, **how: Any) -> pa.Table:
    """Raises InputError."""
    import pyarrow as pa

    try:
        return parquet().read_table(file, **how)
    except (pa.ArrowException, OSError, KeyError) as error:
        raise _damaged(file, error) from None


def _number_of(part: Path) -> int:
    """Of a complete part. Raises InputError for one that holds something else than its runs."""
    import pyarrow as pa

    try:
        rows = parquet().read_metadata(part).num_rows
    except (pa.ArrowException, OSError) as error:
        raise _damaged(part, error) from None
    if rows != PART_RUNS:
        raise _damaged(part, f"{rows} runs instead of {PART_RUNS}")
    return int(part.stem.removeprefix("part-"))


def _damaged(file: Path, why: Exception | str) -> InputError:
    reason = str(why).splitlines()[0].removesuffix(".")
    return InputError(
        f"{file} holds no runs of a campaign ({reason}); of a campaign's folder, remove it: they are flown again"
    )


def read_runs(path: Path, columns: Sequence[str] | None = None) -> pa.Table:
    """The runs of a campaign's folder, or of one Parquet file. Raises InputError when there are none."""
    import pyarrow as pa

    files = part_files(path) if path.is_dir() else [path]
    if not files or not path.exists():
        raise InputError(f"{path} holds no runs; give the folder of a campaign, or a .parquet file saved from one")
    try:
        return pa.concat_tables([_read(file, columns=columns) for file in files])
    except pa.ArrowInvalid as error:
        raise InputError(f"{path} holds runs of more than one campaign ({str(error).splitlines()[0]})") from None


def require_parquet(path: Path) -> None:
    """Raises InputError for a name that says of another form than runs are saved in."""
    if path.suffix.lower() != ".parquet":
        raise InputError(f"{path}: runs are saved as .parquet; end the name in it")


def save_as_one(path: Path, tables: Iterable[pa.Table], schema: pa.Schema) -> None:
    """One file of all runs, written a part at a time."""
    path.parent.mkdir(parents=True, exist_ok=True)
    rough = path.with_suffix(".rough")
    with parquet().ParquetWriter(rough, schema, compression="zstd") as writer:
        for table in tables:
            writer.write_table(table)
    rough.replace(path)
