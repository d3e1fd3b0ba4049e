"""Each report, configuration and parameter, stated once; and the printers that write it out.

The lists themselves stand beside what they define, in ``firmware/protocol/definition/`` and
``emulator/definition/``. ``./dev generate`` prints them as C++, Python and Markdown; the results are
checked in, and a test says when they are stale.
"""
