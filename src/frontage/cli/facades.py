"""`frontage facades`."""

from frontage.cli.console import stage_command

command = stage_command("facades", "Find the facades of a run folder's buildings again.")
