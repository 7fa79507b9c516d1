"""CityJSON 1.0 to 2.0 and CityJSONSeq: buildings as drafts, and a writer for version 2.0.

`read.read_cityjson` and `write.write_cityjson` are the entry functions. The refined model of paper B (section
3) is written to this format first.
"""
