"""The emulator beside what ball arithmetic proves."""
