"""Faults of recorders: found in samples or by the model, reported and undone in one way."""
