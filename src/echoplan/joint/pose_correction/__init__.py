"""Correction: poses that are wrong, found out and set right by what is heard from them."""
