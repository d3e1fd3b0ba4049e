"""Files of what a knob did: writing, reading, replaying."""
