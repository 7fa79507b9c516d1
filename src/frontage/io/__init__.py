"""Files <-> nouns, one module per format; the only door to the disk besides the pipeline."""
