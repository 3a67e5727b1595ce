"""Triangles of glTF 2.0, compressed or not, in float64 and in the order of the file."""

from tilesnav_ref.scene.gltf.single import read_gltf

__all__ = ["read_gltf"]
