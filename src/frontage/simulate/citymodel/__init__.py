"""Scenes built from a city model (CityGML, CityJSON) instead of drawn houses.

`scene.build_model_scene` is the entry function. It keeps the walls and openings of the model, adds what
models lack (reveals, frames, panes, rooms), and lays a street along the longest facades.
"""
