"""Meshes with materials and pictures: writers for binary glTF (GLB) and Wavefront OBJ.

`formats.write_meshes` is the entry function for textured meshes, the textured facades of paper A;
`glb.glb_of` makes the GLB of a model whose meshes have several materials.
"""
