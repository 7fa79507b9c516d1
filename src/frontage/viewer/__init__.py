"""The viewer: a run folder as a site for the browser, served on this machine or written as files.

`site_of` says which files the site has, `serve` serves them, `export` writes them. The program that runs in
the browser is made from `web/`; `program` finds it.
"""
