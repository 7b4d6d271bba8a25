"""What the README tells people to type works as it says."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()
BLOCKS = re.findall(r"```(\w*)\n(.*?)```", README, re.DOTALL)
SHELL = [
    line.split("#")[0].strip() for kind, block in BLOCKS if not kind for line in block.splitlines() if line.strip()
]
PYTHON = [block for kind, block in BLOCKS if kind == "python"]


def run(command: list[str], cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)


def test_the_python_of_the_readme_runs(tmp_path: Path) -> None:
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    assert len(PYTHON) == 1
    script = tmp_path / "readme.py"
    script.write_text("if __name__ == '__main__':\n" + "".join(f"    {line}\n" for line in PYTHON[0].splitlines()))
    done = run([sys.executable, str(script)], tmp_path)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("line", [line for line in SHELL if "MISSION" in line and line.startswith("halfroll")])
def test_a_command_of_the_readme_does_what_it_says(line: str, tmp_path: Path) -> None:
    words = line.replace("MISSION", str(ROOT / "examples" / "first_flight.plan")).split()
    done = run([sys.executable, "-m", *words], tmp_path)
    assert done.returncode == 0, done.stderr
    assert "-o" not in words or (tmp_path / words[words.index("-o") + 1]).stat().st_size > 0


@pytest.mark.parametrize("line", [line for line in SHELL if line.startswith("halfroll")])
def test_each_command_of_the_readme_says_help(line: str, tmp_path: Path) -> None:
    done = run([sys.executable, "-m", "halfroll", line.split()[1], "--help"], tmp_path)
    assert done.returncode == 0
    assert "--" in done.stdout


def test_files_and_pages_the_readme_points_to_exist() -> None:
    for target in re.findall(r"\]\(([^)#:]+)\)", README):
        assert (ROOT / target).exists(), target
    for example in re.findall(r"examples/[\w.]+", README):
        assert (ROOT / example).exists(), example


@pytest.mark.long
def test_make_fly_flies_and_leaves_a_report() -> None:
    done = run(["make", "fly", "ARGS=--out build/readme-flight --scenario ideal"], ROOT)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "flown within limits" in done.stdout + done.stderr
    assert (ROOT / "build" / "readme-flight" / "report.html").stat().st_size > 100_000
