"""Checks that the development script runs; not part of the installed package."""
