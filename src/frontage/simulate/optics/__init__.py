"""Light and surfaces: ray casting, materials, glass, roughness, sun and sky.

`litscene.LitScene` casts view rays into a lit scene and `shading.radiance` turns what they meet into light;
the cameras use both. Lasers use `rays.Tracer` together with `glass`, `roughness` and `lasertexture`.
"""
