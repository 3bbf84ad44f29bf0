"""Pose correction: detect poses that are inconsistent with the pings, and estimate better ones."""
