"""`make audit`: what is installed is what the project pins, unchanged since, and without known holes as far as anybody
can be asked.

Why: code of others runs with our rights. Versions are pinned in constraints.txt and the files of each release, for all
platforms, in hashes.txt (`make hashes`). Needs no network, but for two questions that it says it could not ask:
whether the index still offers those files, and what is known against them (pip-audit, if installed).
"""

from __future__ import annotations

import argparse
import base64
import csv
import hashlib
import re
import subprocess
import sys
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path

ROOT = Path(__file__).parents[1]
OURS = {"halfroll", "pip", "setuptools", "wheel"}  # built here, or what venv itself lays down
HASHED = re.compile(r"^(\S+)==(\S+?)(?: ;.*)? \\\n((?:    --hash=sha256:[0-9a-f]{64}(?: \\)?\n)+)", re.MULTILINE)


def canonical(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def pinned(root: Path = ROOT) -> dict[str, str]:
    lines = (root / "constraints.txt").read_text().splitlines()
    pairs = (line.split("==") for line in lines if line and not line.startswith("#"))
    return {canonical(name): version for name, version in pairs}


def hashed(root: Path = ROOT) -> dict[str, str]:
    """Versions that have hashes."""
    return {canonical(name): version for name, version, _ in HASHED.findall((root / "hashes.txt").read_text())}


def unpinned() -> Iterator[str]:
    pins = pinned()
    for one in metadata.distributions():
        name = canonical(one.metadata["Name"])
        if name not in OURS and pins.get(name) != one.version:
            wanted = pins.get(name, "nothing")
            yield f"{name} {one.version} is installed, constraints.txt has {wanted}: run make build again, or pin it"


def unhashed() -> Iterator[str]:
    hashes = hashed()
    for name, version in pinned().items():
        if hashes.get(name) != version:
            yield f"{name} {version} has no hashes in hashes.txt: run make hashes"
    yield from (
        f"{name} is in hashes.txt and not in constraints.txt: run make hashes" for name in hashes.keys() - pinned()
    )


def changed() -> Iterator[str]:
    """Installed files that are not as their wheel had them."""
    for one in metadata.distributions():
        record = one.read_text("RECORD")
        if canonical(one.metadata["Name"]) in OURS or record is None:
            continue
        for name, digest, _ in csv.reader(record.splitlines()):
            file = Path(str(one.locate_file(name)))
            if not digest.startswith("sha256=") or name.endswith(".pyc"):
                continue
            found = hashlib.sha256(file.read_bytes()).digest() if file.is_file() else b""
            if base64.urlsafe_b64encode(found).rstrip(b"=").decode() != digest.removeprefix("sha256="):
                yield f"{file} is not as it was installed: remove .venv and run make build"


def asked(question: str, *words: str) -> Iterator[str]:
    """What a command finds fault with; nothing where it could not ask."""
    try:
        done = subprocess.run([sys.executable, "-m", *words], capture_output=True, text=True, timeout=900, check=False)
    except subprocess.TimeoutExpired:
        print(f"not asked: {question}: no answer")
        return
    if done.returncode == 0:
        print(f"asked: {question}: nothing found")
        return
    said = done.stderr + done.stdout
    if "No module named" in said or "onnection" in said or "Max retries" in said:
        print(f"not asked: {question}: {said.strip().splitlines()[-1]}")
    else:
        yield f"{question}: {said.strip()}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ask", action="store_true", help="the package index and the advisory service, too")
    faults = [*unpinned(), *unhashed(), *changed()]
    if parser.parse_args().ask:
        hashes = str(ROOT / "hashes.txt")
        install = ("install", "-q", "--dry-run", "--no-deps", "--ignore-installed", "--require-hashes", "-r", hashes)
        faults += asked("are the files of the index those of hashes.txt", "pip", *install)
        faults += asked("is anything known against them", "pip_audit", "--require-hashes", "-r", hashes)
    for fault in faults:
        print(fault)
    print(f"{len(list(pinned()))} pinned packages, {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
