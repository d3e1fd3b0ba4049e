"""Modules printed from the definitions, and the methods of their classes."""
