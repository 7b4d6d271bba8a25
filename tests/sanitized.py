"""`pytest -p sanitized`: the modules built in the folder that SANITIZED_BUILD names stand for those that are installed.

Why: they are loaded before halfroll is, so that every test that runs in the process runs them. Python itself has no
sanitizer, so their runtime is loaded in front of it (system/test_sanitized_flights.py says how).
"""

import importlib.util
import os
import sys
from pathlib import Path

for name in ("halfroll._firmware", "halfroll._planner"):
    [file] = Path(os.environ["SANITIZED_BUILD"], "ground", "bindings").glob(f"{name.partition('.')[2]}.*.so")
    spec = importlib.util.spec_from_file_location(name, file)
    assert spec is not None
    assert spec.loader is not None
    sys.modules[name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sys.modules[name])
