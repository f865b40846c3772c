"""Backends: each writes a model as the files of one kind of program, over the same C."""
