"""Files with faces, read as they are, so that the validator can judge them.

`read.read_shapes` is the entry function; `formats.py` lists the formats. Nothing is repaired, merged or
triangulated here: the validation of the models that paper B builds (section 3) must see what the file says.
"""
