"""What uses the format: reading a tileset and following deltas from cell to cell."""
