"""Likelihood of pings given landmarks: detections, non-detections, multipath and clutter."""
