"""What of the simulation a scene needs, for many scenes."""
