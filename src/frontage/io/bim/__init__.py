"""Building information models: walls with voids and what fills them, as IFC.

`ifc.write_ifc` is the entry function; `parts` holds what it writes.
"""
