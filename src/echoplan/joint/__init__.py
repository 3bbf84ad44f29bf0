"""The estimator: landmarks, calibration of the sonar and poses that maximise the likelihood of all pings together."""
