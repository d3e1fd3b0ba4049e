"""Recordings of a knob: writing, reading, replaying."""
