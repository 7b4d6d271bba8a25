"""What SECURITY.md promises: nothing that is read is run, nothing listens beyond this machine unasked, and what is
installed is what was pinned."""

from __future__ import annotations

import ast
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from test_architecture import ROOT, tracked

sys.path.insert(0, str(ROOT / "cmake"))
import audit

FORBIDDEN_CALLS = {"eval", "exec", "compile", "__import__"}
FORBIDDEN_MODULES = {"pickle", "marshal", "shelve", "dill", "yaml", "code", "codeop", "imp", "runpy"}
OF_A_SHELL = {"os.system", "os.popen", "subprocess.getoutput", "subprocess.getstatusoutput"}
SHIPPED = [ROOT / "ground", ROOT / "cmake", ROOT / "docs", ROOT / "examples"]
OURS = [path for path in tracked(".py") if any(folder in path.parents for folder in SHIPPED)]


def dangers(tree: ast.AST) -> list[str]:
    """What in this code could run something that was read."""
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import | ast.ImportFrom):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else [each.name for each in node.names]
            found += [f"import {name}" for name in names if name.split(".")[0] in FORBIDDEN_MODULES]
        if not isinstance(node, ast.Call):
            continue
        called = node.func
        if isinstance(called, ast.Name) and called.id in FORBIDDEN_CALLS:
            found.append(f"{called.id}()")
        if isinstance(called, ast.Attribute) and ast.unparse(called) in OF_A_SHELL:
            found.append(f"{ast.unparse(called)}()")
        for option in node.keywords:
            if option.arg in ("shell", "allow_pickle") and not (
                isinstance(option.value, ast.Constant) and option.value.value is False
            ):
                found.append(f"{option.arg}=")
    return found


def test_nothing_that_is_read_is_run() -> None:
    assert len(OURS) > 60
    found = {path: dangers(ast.parse(path.read_text(encoding="utf-8"))) for path in OURS}
    assert {str(path): what for path, what in found.items() if what} == {}


@pytest.mark.parametrize(
    "code",
    [
        "import pickle",
        "from yaml import load",
        "eval(text)",
        "os.system(text)",
        "subprocess.run(text, shell=True)",
        "np.load(file, allow_pickle=True)",
        "np.load(file, allow_pickle=wanted)",
    ],
)
def test_and_what_would_be_is_found(code: str) -> None:
    assert dangers(ast.parse(code))


def test_python_listens_on_loopback_alone() -> None:
    """Sockets are made in one module, and bound to one address."""
    makers = [
        path
        for path in OURS
        if re.search(r"\bsocket\.socket\((?!fileno)|\bcreate_server\(|http\.server", path.read_text())
    ]
    assert [path.name for path in makers if path.name != "server.py"] == ["transport.py"]  # the page: host=LOOPBACK
    assert re.findall(r"\.bind\(\((\w+),", makers[0].read_text()) == ["LOOPBACK"]
    assert 'LOOPBACK = "127.0.0.1"' in makers[0].read_text()


def test_the_simulator_listens_on_loopback_unless_told_otherwise_and_then_warns() -> None:
    sitl = shutil.which("halfroll-sitl", path=str(Path(sys.executable).parent))
    assert sitl is not None
    ports = [f"--{end}-{link}=0" for link in ("offboard", "gcs", "companion") for end in ("port", "peer")]
    listening = [
        sitl,
        "--speed=0",
        "--duration=0.01",
        *(port.replace("=0", "=39999") for port in ports if "peer" in port),
    ]

    def warned(*options: str) -> list[str]:
        own = [f"--port-{link}={39000 + i}" for i, link in enumerate(("offboard", "gcs", "companion"))]
        ended = subprocess.run([*listening, *own, *options], capture_output=True, text=True, check=True, timeout=60)
        return ended.stderr.splitlines()

    assert warned() == []
    assert warned("--bind", "127.0.0.2") == []
    (sentence,) = warned("--bind", "0.0.0.0")
    assert "listening on 0.0.0.0, anybody who reaches it can fly this vehicle" in sentence


def test_every_pinned_package_has_hashes_and_nothing_says_where_it_came_from() -> None:
    assert list(audit.unhashed()) == []
    assert set(audit.hashed()) == set(audit.pinned())
    for name in ("constraints.txt", "hashes.txt"):
        assert not re.search(r"https?:|file:|index-url|find-links|\.(org|com|io)\b", (ROOT / name).read_text())


def test_a_pin_without_its_hash_and_a_hash_of_another_version_are_found(tmp_path: Path) -> None:
    (tmp_path / "constraints.txt").write_text("one==1.0\nTwo_x==2.0\n")
    (tmp_path / "hashes.txt").write_text("one==1.1 \\\n    --hash=sha256:" + "a" * 64 + "\n")
    assert audit.pinned(tmp_path) == {"one": "1.0", "two-x": "2.0"}
    assert audit.hashed(tmp_path) == {"one": "1.1"}


def test_an_installed_file_that_was_changed_is_found(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    package = tmp_path / "victim-1.0.dist-info"
    package.mkdir()
    (package / "METADATA").write_text("Metadata-Version: 2.1\nName: victim\nVersion: 1.0\n")
    (package / "RECORD").write_text("victim.py,sha256=47DEQpj8HBSa-_TImW-5JCeuQeRkm5NMpJWZG3hSuFU,0\n")  # of nothing
    (tmp_path / "victim.py").write_text("")
    monkeypatch.setattr(audit.metadata, "distributions", lambda: metadata_of(tmp_path))
    assert list(audit.changed()) == []
    (tmp_path / "victim.py").write_text("import os\n")
    assert [fault.split(" is not")[0] for fault in audit.changed()] == [str(tmp_path / "victim.py")]
    assert [fault.split(",")[0] for fault in audit.unpinned()] == ["victim 1.0 is installed"]


def metadata_of(folder: Path) -> list[audit.metadata.Distribution]:
    return list(
        audit.metadata.MetadataPathFinder.find_distributions(
            audit.metadata.DistributionFinder.Context(path=[str(folder)])
        )
    )
