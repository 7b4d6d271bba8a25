"""Print what pyproject.toml asks for (build, run, campaigns and development, or the arrays named), one a line.

Why: the editable install builds without isolation, so its build requirements must be in the environment first,
and pyproject.toml stays the only list.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

# pip reads pyproject.toml before any TOML reader need exist on Python 3.10, so the few arrays are cut out by pattern.
text = Path(__file__).parents[1].joinpath("pyproject.toml").read_text()
for key in sys.argv[1:] or ("requires", "dependencies", "view", "campaign", "cluster", "dev"):
    block = re.search(rf"^{key} = \[\n(.*?)^\]", text, re.MULTILINE | re.DOTALL)
    if block is None:
        sys.exit(f"pyproject.toml has no array {key!r}")
    for requirement in re.findall(r'^\s*"([^"]+)"', block.group(1), re.MULTILINE):
        name, _, marker = (part.strip() for part in requirement.partition(";"))
        if not marker or (sys.version_info < (3, 11)):
            print(name.replace(" ", ""))
