"""Questions to a finished run: where an opening is, what a pixel is in the world, which photos show it.

They read the run folder through `frontage.pipeline.store` and change nothing. `open_run` is the entry.
"""
