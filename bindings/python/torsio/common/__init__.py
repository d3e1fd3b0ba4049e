"""Shared by the package: checks, files written whole, pictures, words of the screen."""
