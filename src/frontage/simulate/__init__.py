"""Simulated streets: scenes of houses and obstacles, the sensors that record them, and the exact truth.

A simulated street is a `scene.Scene`: triangles that know their surface and its material, together with the
plans (walls, openings, protrusions) that they were built from. `spec.parse_spec` reads what a user asks for;
`street.build.build_street` draws a scene from that, and `citymodel.scene.build_model_scene` builds one from a
city model. Terrestrial scanners, a mapping vehicle and cameras record it
(`sensors.terrestrial.scan_stations`, `sensors.mobile.drive`, `sensors.photograph.iter_photographs`),
`survey.survey_model` derives the LoD2 city model that a surveying office would have, and `truth` writes down
what was really there.

Every random number comes from a seeded generator: the same specification gives the same bytes. Functions
named `draw_...` that take a `meshing.Pen` add triangles to the scene; the others draw random properties.
"""
