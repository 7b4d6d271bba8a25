"""Link what CMake builds into the virtual environment of an editable install.

Why: pip copies the built files once; with links, `cmake --build` alone makes the next run use the new code.
"""

from __future__ import annotations

import sys
import sysconfig
from pathlib import Path

build = Path(sys.argv[1]).resolve()
package = Path(sysconfig.get_path("platlib")) / "halfroll"
scripts = Path(sysconfig.get_path("scripts"))
package.mkdir(exist_ok=True)


def link(target: Path, place: Path) -> None:
    place.unlink(missing_ok=True)
    place.symlink_to(target)


for pattern in ("_firmware*.so", "_planner*.so"):
    for module in build.glob(f"ground/bindings/{pattern}"):
        link(module, package / module.name)
link(build / "generated" / "_dialect.py", package / "_dialect.py")
link(build / "sim" / "halfroll-sitl", scripts / "halfroll-sitl")
