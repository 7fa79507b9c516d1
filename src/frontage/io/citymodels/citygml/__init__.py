"""CityGML 1, 2 and 3: buildings as drafts, and a writer for versions 2.0 and 3.0.

`read.read_citygml` and `write.write_citygml` are the entry functions. The coarse building model of paper B
(section 2) comes in such a file, and its refined one (section 3) leaves in one.
"""
