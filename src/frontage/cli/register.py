"""`frontage register`."""

from frontage.cli.console import stage_command

command = stage_command(
    "register", "Register the approximate scans of a run folder against its city model again."
)
