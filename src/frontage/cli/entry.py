"""The entry point of the program `frontage`: Ctrl-C ends it quietly, also while Python still imports it."""

import sys


def main() -> None:
    """Import the command line and run it; exits with 130 when interrupted."""
    try:
        from frontage.cli.main import main as group

        group()
    except KeyboardInterrupt:
        sys.stderr.write("interrupted\n")
        sys.exit(130)


if __name__ == "__main__":
    main()
