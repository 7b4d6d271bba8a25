"""The tree keeps the shape that docs/architecture.md draws.

Why: layers that may be crossed once are crossed for ever. The two tables there are the specification; this file reads
them.
"""

from __future__ import annotations

import ast
import io
import re
import subprocess
import tokenize
from fnmatch import fnmatch
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "ground" / "halfroll"
DOCUMENT = (ROOT / "docs" / "architecture.md").read_text()
GENERATED_HEADERS = "development/mavlink.h"
ONLY_USER = {  # package: the modules that may import it, as in the table of layers
    "pymavlink": "wire/link",
    "matplotlib": "drawing, results/pictures, results/report_pdf, campaign/page",
    "pyulog": "results/log",
    "typer": "cli/*",
    "rich": "console, console_flight, console_logs, campaign_console, viewer/server",
    "viser": "viewer/server",
}
AXES_OF_THE_WIRE = {
    "frames",
    "geodesy",
    "mission_items",
    "mission_files",
    "point_files",
    "link",
    "codec",
    "codec_encode",
    "codec_telemetry",
    "messages",
    "wire_ids",
    "px4_topics",
}
STORED_AS_THEY_CAME = {"commands", "autopilot_commands", "vehicle_status"}


def table(first_column: str) -> list[dict[str, str]]:
    """Rows of the Markdown table whose first heading is `first_column`."""
    lines = DOCUMENT[DOCUMENT.index(f"| {first_column} |") :].splitlines()
    split = [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines]
    rows = split[2:]
    end = next((i for i, cells in enumerate(rows) if not cells), len(rows))
    return [dict(zip(split[0], cells, strict=True)) for cells in rows[:end]]


def patterns(cell: str) -> list[str]:
    return [pattern.replace(r"\|", "|") for pattern in re.findall(r"`([^`]+)`", cell)]


def tracked(*suffixes: str) -> list[Path]:
    listed = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, check=True, capture_output=True, text=True
    )
    return [ROOT / name for name in listed.stdout.splitlines() if name.endswith(suffixes) and (ROOT / name).exists()]


UNITS = table("unit")
LAYERS = table("layer")
CPP = tracked(".cpp", ".hpp", ".def")


def unit_of(path: str) -> dict[str, str] | None:
    """The row whose path pattern fits best: the longest one."""
    fitting = []
    for row in UNITS:
        pattern = row["path"].strip("`")
        one_level = not pattern.endswith("**") and "/" in pattern
        if fnmatch(path, pattern) and not (one_level and path.count("/") != pattern.count("/")):
            fitting.append(row)
    return max(fitting, key=lambda row: len(row["path"]), default=None)


def code_of(cpp: Path) -> str:
    """Source without comments and string literals; include lines are kept whole."""
    text = cpp.read_text()
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
    lines = []
    for line in text.splitlines():
        if not line.lstrip().startswith("#include"):
            line = re.sub(r'"(?:\\.|[^"\\])*"', '""', line)
        lines.append(re.sub(r"//.*", "", line))
    return "\n".join(lines)


def resolve(include: str, cpp: Path) -> str | None:
    """Path in the tree that an include names, if it is ours."""
    for base in (ROOT, ROOT / "firmware", ROOT / "ground", cpp.parent):
        if (base / include).is_file():
            return (base / include).relative_to(ROOT).as_posix()
    return None


@pytest.mark.parametrize("cpp", CPP, ids=lambda p: p.relative_to(ROOT).as_posix())
def test_a_cpp_file_belongs_to_a_unit_and_knows_only_what_that_unit_may(cpp: Path) -> None:
    name = cpp.relative_to(ROOT).as_posix()
    row = unit_of(name)
    assert row is not None, f"{name} is in no row of docs/architecture.md"
    allowed = {part.strip() for part in row["own"].split(",")}
    code = code_of(cpp)
    for include in re.findall(r'#include "([^"]+)"', code):
        target = resolve(include, cpp)
        if target is None:
            assert include == GENERATED_HEADERS or include.endswith(".inc"), f"{name} includes unknown {include}"
            continue
        other = unit_of(target)
        assert other is not None
        assert other["unit"] in allowed, f"{name} ({row['unit']}) may not include {target} ({other['unit']})"
    for pattern in patterns(row["never"]):
        found = re.search(pattern, code)
        assert found is None, f"{name}: {found.group(0) if found else ''!r} is never in {row['unit']}"


def test_only_the_codec_sees_generated_mavlink() -> None:
    users = {
        cpp.relative_to(ROOT).as_posix() for cpp in CPP if re.search(r'#include "[^"]*mavlink[^"]*"', code_of(cpp))
    }
    assert {user for user in users if not user.startswith(("firmware/link/codec", "tests/cpp/"))} == set()


def imports_of(module: Path) -> tuple[set[str], set[str]]:
    """(modules of ours, top-level packages of others), lazy imports included, typing-only ones too."""
    ours, others = set(), set()
    for node in ast.walk(ast.parse(module.read_text())):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            inside = base.partition(".")[0] in ("halfroll", "")
            names = [f"{base}.{alias.name}" for alias in node.names] if inside else [base]
            if node.level:
                names = [f"halfroll.{name.lstrip('.')}" for name in names]
        else:
            continue
        for name in names:
            parts = name.split(".")
            if parts[0] == "halfroll":
                paths = ("/".join(parts[1:end]) for end in range(len(parts), 1, -1))
                ours |= {next((path for path in paths if (PACKAGE / f"{path}.py").exists()), "__init__")}
            else:
                others.add(parts[0])
    return ours, others


PYTHON = sorted(PACKAGE.rglob("*.py"))


def module_name(module: Path) -> str:
    """`paper/claims` for a module of a package inside ours."""
    return module.relative_to(PACKAGE).with_suffix("").as_posix()


def names(cell: str) -> set[str]:
    return {part.strip() for part in cell.split(",")} - {""}


def layer_of(module: str) -> dict[str, str] | None:
    return next((row for row in LAYERS if any(fnmatch(module, name) for name in names(row["modules"]))), None)


@pytest.mark.parametrize("module", PYTHON, ids=module_name)
def test_a_python_module_imports_only_its_own_layer_and_those_its_row_names(module: Path) -> None:
    row = layer_of(module_name(module))
    assert row is not None, f"{module.name} is in no layer of docs/architecture.md"
    ours, others = imports_of(module)
    for imported in ours - {"__init__"}:
        layer = layer_of(imported)
        assert layer is not None
        assert layer["layer"] in names(row["may import"]) | {row["layer"]}, f"{module.stem} may not import {imported}"
    for package in others & ONLY_USER.keys():
        assert any(fnmatch(module_name(module), user) for user in names(ONLY_USER[package])), (
            f"{package} is not for {module_name(module)}"
        )
    for pattern in patterns(row["never"]):
        assert re.search(pattern, stripped(module)) is None, f"{module.stem}: {pattern}"


def stripped(module: Path) -> str:
    """Source without comments and strings."""
    skip = (tokenize.COMMENT, tokenize.STRING)
    tokens = tokenize.generate_tokens(io.StringIO(module.read_text()).readline)
    return " ".join(token.string for token in tokens if token.type not in skip)


def test_python_modules_form_no_cycle() -> None:
    graph = {
        module_name(module): imports_of(module)[0] - {module_name(module), "__init__"}
        for module in PYTHON
        if module_name(module) != "__init__"
    }
    assert list(TopologicalSorter(graph).static_order())


def test_the_wires_axes_are_named_only_where_they_are_converted() -> None:
    word = re.compile(r"(?i)(?<![A-Za-z])(ned|frd|degE7)(?![A-Za-z])")
    for path in [p for p in CPP + PYTHON if "tests" not in p.parts]:
        text = code_of(path) if path.suffix != ".py" else stripped(path)
        if path.stem not in AXES_OF_THE_WIRE | STORED_AS_THEY_CAME:
            assert word.search(text) is None, f"{path.name} names the wire's axes: {word.search(text)}"


def test_no_file_is_named_after_nothing() -> None:
    vague = re.compile(r"^(utils?|helpers?|common|misc|manager)$")
    for path in tracked(".py", ".cpp", ".hpp"):
        assert not vague.match(path.stem), path


@pytest.mark.parametrize("path", [p for p in CPP + PYTHON if p.suffix in (".py", ".hpp")], ids=lambda p: p.name)
def test_each_module_opens_with_why_it_exists(path: Path) -> None:
    head = path.read_text().lstrip()
    assert head.startswith(('"""', "//")), path.name
