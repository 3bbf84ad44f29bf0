"""Outline: how far walls go, where they meet, and the map that this makes."""
