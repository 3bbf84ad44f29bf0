"""Search for the set of landmarks that maximises the likelihood of the pings."""
