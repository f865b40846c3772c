"""Robots and simulators of their own, which nothing of the package under test is in."""
