"""`pytest -p sanitized`: the modules built in the folder that SANITIZED_BUILD names stand for those that are installed.

Why: they are loaded before halfroll is, so that every test that runs in the process runs them. Python itself has no
sanitizer, so their runtime is loaded in front of it (test_sanitized_code.py says how).
"""

import importlib.util
import os
import sys
from pathlib import Path

built = sorted(Path(os.environ["SANITIZED_BUILD"], "ground", "bindings").glob("_*.so"))
assert built, "no module is built under sanitizers"
for file in built:
    name = f"halfroll.{file.name.partition('.')[0]}"
    spec = importlib.util.spec_from_file_location(name, file)
    assert spec is not None
    assert spec.loader is not None
    sys.modules[name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sys.modules[name])
