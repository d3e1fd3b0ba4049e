"""What `./dev` runs: builds, checks, printers and releases; no part of the installed package."""
