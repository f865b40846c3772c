"""Faults of recorders. Samples or the model reveal them; all are reported and undone in one way."""
