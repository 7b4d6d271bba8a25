"""The command line. Why: arguments, exit codes and errors; everything is computed elsewhere, and imported only by the
command that needs it, so that `--help` comes at once.
"""

from __future__ import annotations

import sys

__all__ = ["main"]


def main() -> None:
    """The `halfroll` command; Ctrl-C while it is still being loaded ends it as it does later."""
    try:
        from halfroll.cli.app import main as run
    except KeyboardInterrupt:
        print("stopped", file=sys.stderr)
        sys.exit(130)
    run()
