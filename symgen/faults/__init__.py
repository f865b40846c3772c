"""Faults of recorders: found on samples or by the model, told and undone in one way."""
