"""The command line, also as `python -m skewbridge`."""

import sys


def main() -> None:
    """Run the command line; Ctrl-C while modules are imported is one line, too."""
    try:
        from skewbridge.cli import main as commands

        commands()
    except KeyboardInterrupt:
        sys.stderr.write("interrupted\n")
        raise SystemExit(130) from None


if __name__ == "__main__":
    main()
