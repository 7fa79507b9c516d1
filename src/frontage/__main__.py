"""`python -m frontage` is the command line."""

from frontage.cli.entry import main

main()
