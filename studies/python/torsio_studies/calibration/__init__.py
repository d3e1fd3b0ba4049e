"""Whether `torsio calibrate` finds what emulated knobs hide, and refuse what is broken."""
