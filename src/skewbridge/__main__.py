"""`python -m skewbridge` is the command line."""

from skewbridge.cli import main

main()
