"""Demonstrations: what `torsio demo NAME` runs."""
