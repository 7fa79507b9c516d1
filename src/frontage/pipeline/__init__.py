"""From a project to a run folder: what a stage is (`graph`), the stages, the folder (`store`), and `run`.

The chain is that of paper A to the ortho-image and of paper B to the solid. `run.run` performs it.
"""
