"""`frontage export`."""

from frontage.cli.console import stage_command

command = stage_command(
    "export",
    "Write the textured model (model/facades.glb, facades.obj) and the products of a run folder again.",
)
