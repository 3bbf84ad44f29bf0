"""Adjustment: features, sonar and poses together by sparse least squares, and how well they are known."""
