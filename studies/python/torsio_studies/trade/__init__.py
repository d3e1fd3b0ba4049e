"""Parts of the simulation that scenes need, for many scenes."""
