"""The command line. Why: arguments, exit codes and errors; everything is computed elsewhere, and imported only by the
command that needs it, so that `--help` comes at once.
"""

from halfroll.cli.app import main

__all__ = ["main"]
