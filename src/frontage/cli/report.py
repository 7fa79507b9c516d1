"""`frontage report`."""

from frontage.cli.console import stage_command

command = stage_command("report", "Write report.html of a run folder again.")
