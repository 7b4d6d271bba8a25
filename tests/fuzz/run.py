"""`make fuzz TIME=seconds`: each target is fuzzed for so long, from the corpus kept.

Figures are printed and written. Exit code 1 if anything was found: the input is named, and goes into tests/fuzz/found
once it is mended. `--keep` begins with what the tests say, too, and writes what was learnt into tests/fuzz/corpus: as
few inputs as reach the same code.
`--campaign` adds executions and processor time to those of tests/fuzz/campaign.json, and puts there what the corpus
reaches now: so a campaign may be run in pieces, whenever a processor is idle.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import resource
import subprocess
import sys
import tempfile
import zipfile
from fnmatch import fnmatch
from pathlib import Path

ROOT = Path(__file__).parents[2]
BUILD = ROOT / "build" / "fuzz"
HERE = ROOT / "tests" / "fuzz"
CAMPAIGN = HERE / "campaign.json"
TARGETS = ("byte_stream", "mission_flight", "mission_talk", "offboard_flight", "stored_images")
COUNTED = [line[4:] for line in (HERE / "counted.txt").read_text().splitlines() if line.startswith("src:")]
_LONGEST_INPUT = 4096
_HANGS_S, _HANGS_IDLE_S = 20, 300  # of the clock: a campaign may run on a processor that is idle and then is not


def program(target: str) -> Path:
    return BUILD / "tests" / "fuzz" / f"fuzz_{target}"


def unpack(target: str, folder: Path) -> None:
    """The inputs that are kept, and those that once failed."""
    folder.mkdir(parents=True, exist_ok=True)
    kept = HERE / "corpus" / f"{target}.zip"
    if kept.exists():
        zipfile.ZipFile(kept).extractall(folder)
    for found in (HERE / "found").glob(f"{target}-*"):
        (folder / found.name).write_bytes(found.read_bytes())


def pack(target: str, inputs: Path) -> None:
    """The same inputs give the same archive, byte for byte."""
    (HERE / "corpus").mkdir(exist_ok=True)
    with zipfile.ZipFile(HERE / "corpus" / f"{target}.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted(inputs.iterdir()):
            archive.writestr(zipfile.ZipInfo(path.name), path.read_bytes(), zipfile.ZIP_DEFLATED)


def seeds(folder: Path) -> None:
    """What clients say in the contract's tests; half a minute, once."""
    if (folder / "byte_stream").exists():
        return
    subprocess.run(
        [
            sys.executable,
            "-m",
            "pytest",
            "-q",
            "-p",
            "fuzz.seeds",
            "--seeds",
            folder,
            "--ignore",
            ROOT / "tests" / "system" / "contract" / "test_extremes.py",  # more than anybody says
            ROOT / "tests" / "system" / "contract",
        ],
        env={**os.environ, "PYTHONPATH": str(ROOT / "tests")},
        cwd=ROOT,
        check=True,
        stdout=subprocess.DEVNULL,
    )


def fuzz(target: str, seconds: int, hangs_s: int, work: Path) -> dict[str, object]:
    corpus, found = work / "corpus" / target, work / "found"
    unpack(target, corpus)
    found.mkdir(exist_ok=True)
    before = set(found.iterdir())
    log = work / f"{target}.log"
    taken_s = cpu_s()
    with log.open("w") as out:
        subprocess.run(
            [
                program(target),
                f"-max_total_time={seconds}",
                f"-max_len={_LONGEST_INPUT}",
                "-print_final_stats=1",
                f"-timeout={hangs_s}",
                f"-artifact_prefix={found}/{target}-",
                corpus,
                work / "seeds" / target,
            ],
            stdout=out,
            stderr=out,
            env={**os.environ, "LLVM_PROFILE_FILE": str(work / "profiles" / f"{target}.profraw")},
        )
    runs = re.search(r"number_of_executed_units: (\d+)", log.read_text())
    new = sorted(path for path in set(found.iterdir()) - before if "slow-unit" not in path.name)
    for path in new:
        print(f"{target}: {path} breaks it, see {log}")
    executions = int(runs[1]) if runs else 0
    print(f"{target:18}{executions:>10} executions{len(list(corpus.iterdir())):>7} inputs kept{len(new):>4} crashes")
    return {"name": target, "executions": executions, "cpu_s": round(cpu_s() - taken_s), "crashes": len(new)}


def cpu_s() -> float:
    """Processor time of all that ran for us and has ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def replay(target: str, work: Path) -> None:
    """The corpus once, to count the lines that it reaches."""
    profile = work / "profiles" / f"{target}.profraw"
    words = [program(target), "-runs=0", f"-max_len={_LONGEST_INPUT}", work / "corpus" / target]
    environment = {**os.environ, "LLVM_PROFILE_FILE": str(profile)}
    subprocess.run(words, cwd=work, check=True, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def added(results: list[dict[str, object]], reached: dict[str, float]) -> dict[str, object]:
    """The campaign so far and these runs."""
    known = json.loads(CAMPAIGN.read_text()) if CAMPAIGN.exists() else {"targets": {}}
    targets = {name: dict(row) for name, row in known["targets"].items()}
    for each in results:
        row = targets.setdefault(str(each["name"]), {"executions": 0, "cpu_s": 0, "crashes": 0})
        for what in row:
            row[what] += each[what]
    return {
        "targets": dict(sorted(targets.items())),
        "lines_reached_percent": {n: round(x, 1) for n, x in reached.items()},
    }


def merge(target: str, work: Path) -> None:
    with tempfile.TemporaryDirectory() as folder:
        least = Path(folder)
        inputs = (work / "corpus" / target, work / "seeds" / target)
        words = [program(target), "-merge=1", f"-max_len={_LONGEST_INPUT}", least, *inputs]
        subprocess.run(words, cwd=work, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        pack(target, least)


def lines_reached(work: Path) -> dict[str, float]:
    """Share of the lines of link and mission code that ran, by file and in all [%]."""
    merged = work / "merged.profdata"
    subprocess.run(["llvm-profdata", "merge", "-o", merged, *(work / "profiles").glob("*.profraw")], check=True)
    objects = [word for target in TARGETS[1:] for word in ("-object", program(target))]
    words = ["llvm-cov", "export", "-summary-only", f"-instr-profile={merged}", program(TARGETS[0]), *objects]
    report = json.loads(subprocess.run(words, check=True, capture_output=True).stdout)
    files = [each for each in report["data"][0]["files"] if any(fnmatch(each["filename"], name) for name in COUNTED)]
    lines = {str(Path(each["filename"]).relative_to(ROOT)): each["summary"]["lines"] for each in files}
    shares = {name: 100.0 * each["covered"] / max(each["count"], 1) for name, each in sorted(lines.items())}
    shares["all"] = 100.0 * sum(x["covered"] for x in lines.values()) / sum(x["count"] for x in lines.values())
    return shares


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=int, default=60, help="for each target")
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--keep", action="store_true")
    parser.add_argument("--campaign", action="store_true")
    parser.add_argument("targets", nargs="*", default=TARGETS)
    options = parser.parse_args()
    work: Path = BUILD / "run"
    (work / "profiles").mkdir(parents=True, exist_ok=True)
    if options.keep or options.campaign:
        seeds(work / "seeds")
    hangs_s = _HANGS_IDLE_S if options.campaign else _HANGS_S
    results = [fuzz(target, options.seconds, hangs_s, work) for target in options.targets]
    if options.campaign:
        for target in TARGETS:
            unpack(target, work / "corpus" / target)
            replay(target, work)
    reached = lines_reached(work)
    for name, share in reached.items():
        print(f"{share:6.1f} % of lines  {name}")
    if options.keep:
        for target in options.targets:
            merge(target, work)
    figures = {"targets": results, "lines_reached_percent": reached}
    options.output.write_text(json.dumps(figures, indent=2) + "\n")
    if options.campaign:
        CAMPAIGN.write_text(json.dumps(added(results, reached), indent=2) + "\n")
    return 1 if any(each["crashes"] for each in results) else 0


if __name__ == "__main__":
    sys.exit(main())
