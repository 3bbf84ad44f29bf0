"""Extraction of the map: extents of walls, their corners and openings."""
