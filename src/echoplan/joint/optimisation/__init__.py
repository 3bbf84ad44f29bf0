"""Nonlinear least-squares optimisation of landmarks, calibration and poses, and the covariance of the result."""
