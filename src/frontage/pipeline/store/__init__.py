"""The run folder: the only code that reads and writes it, typed both ways.

`Store` reads and writes its nouns, `markers` say what is finished and which files that promises, `results`
are what stages tell. The layout of the folder is a contract, because users script against it.
"""
