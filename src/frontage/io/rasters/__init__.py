"""Ortho-images on disk: GeoTIFF bands in the facade's plane, a JPEG, and the sidecar `ortho.json`.

`ortho.write_ortho` and `ortho.read_ortho` are the entry functions; `sidecar.OrthoSidecar` is everything that
`ortho.json` says, typed. The sidecar carries paper A's relation between a pixel and its world position (eq.
2-4).
"""
