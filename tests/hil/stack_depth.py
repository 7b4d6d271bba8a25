"""How deep the stack of an image can get, from the compiler's call graph.

Why: painting sees the deepest path flown, this the deepest chain of calls by name there is. Calls through pointers end
a chain; the C library's functions count as nothing. A cycle would have no bound, and is an error.
"""

from __future__ import annotations

import re
from pathlib import Path

_NODE = re.compile(r'node: \{ title: "([^"]+)" label: "[^"]*?\\n(\d+) bytes \(')
_EDGE = re.compile(r'edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"')


def deepest_chain(build: Path) -> tuple[int, list[str]]:
    """[bytes], and the functions of the chain, outermost first."""
    own: dict[str, int] = {}
    calls: dict[str, set[str]] = {}
    for file in build.rglob("*.ci"):
        text = file.read_text()
        for name, size in _NODE.findall(text):
            own[name] = max(own.get(name, 0), int(size))
        for caller, called in _EDGE.findall(text):
            calls.setdefault(caller, set()).add(called)
    known: dict[str, tuple[int, list[str]]] = {}

    def below(name: str, path: tuple[str, ...]) -> tuple[int, list[str]]:
        if name in path:
            raise RecursionError(" -> ".join((*path, name)))
        if name not in known:
            deepest = max((below(called, (*path, name)) for called in calls.get(name, ())), default=(0, []))
            known[name] = (own.get(name, 0) + deepest[0], [name, *deepest[1]])
        return known[name]

    return max(below(name, ()) for name in own)
