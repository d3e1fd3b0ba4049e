"""The commands of ``./dev``.

The script finds a Python and runs this package with it, before there is an environment: only the
standard library is imported here. What needs more runs in the environment, as a program.
"""
