"""Laser scans: files to `Scan` nouns and back, one module per format, listed in `formats.py`.

`read.read_scans` is the entry function: it finds the format of a file and returns its scans in local metres.
Scans keep their sensor positions and the beams that did not return wherever the file has them; the evidence
for openings (paper B, section 3) rests on these rays.
"""
