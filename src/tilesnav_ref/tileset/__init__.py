"""Writing: deltas, glTF contents, the nav file and tileset.json."""
