"""The methods of the 2018 paper and of the literature, one module each, and the parts that they share."""
