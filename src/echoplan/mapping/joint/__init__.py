"""Joint: one account of everything that was heard, by features, sonar and poses that explain it together."""
