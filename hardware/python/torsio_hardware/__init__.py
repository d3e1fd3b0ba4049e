"""One Torsio knob to build: its spring, parts, drawings and wiring, and a rehearsal of it all."""
