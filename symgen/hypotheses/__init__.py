"""What may be missing or wrong, and the search among it."""
