"""The programs behind `./dev`: builds, checks, printers and releases. They are not installed."""
