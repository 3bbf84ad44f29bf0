"""Estimator that maximises the likelihood of all pings over landmarks, sonar calibration and poses together."""
