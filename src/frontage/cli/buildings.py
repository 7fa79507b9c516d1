"""`frontage buildings`."""

from frontage.cli.console import stage_command

command = stage_command("buildings", "Split the street of a run folder into buildings again.")
