"""What happens to readings before anything is extracted: validity and the K-means filter."""

from echoplan.preprocessing.kmeans import KmeansSettings, echo_points, kmeans_filter
from echoplan.preprocessing.validity import is_valid, valid_pings

__all__ = ["KmeansSettings", "echo_points", "is_valid", "kmeans_filter", "valid_pings"]
