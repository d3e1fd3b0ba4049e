"""Does `torsio calibrate` find what emulated knobs hide, and refuse what is broken?"""
