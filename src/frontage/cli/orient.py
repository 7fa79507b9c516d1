"""`frontage orient`."""

from frontage.cli.console import stage_command

command = stage_command("orient", "Orient the free photos of a run folder against its scans again.")
