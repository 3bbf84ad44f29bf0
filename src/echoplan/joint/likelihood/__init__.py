"""The likelihood of pings given landmarks: detections, missed detections, multipath and clutter."""
