"""`python -m halfroll`. Why: the command line where the `halfroll` script is not on the path."""

from halfroll.cli import main

if __name__ == "__main__":
    main()
