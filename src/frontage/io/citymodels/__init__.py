"""City models of every common format, as buildings in local metres; and writers for CityJSON and CityGML.

`read.read_city_model` is the entry function. Every reader of the registry in `formats.py` fills `Draft`s;
`draft.finish` turns these into buildings. The coarse model is what paper B registers scans to (section 2.1)
and refines (section 3).
"""
