"""The commands of ``./dev``.

The script finds a Python and runs this package with it, before there is an environment: only the
standard library is imported here. Programs that need more run in the environment.
"""
