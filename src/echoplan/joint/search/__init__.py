"""Search: the features that explain the pings, and what else could."""
