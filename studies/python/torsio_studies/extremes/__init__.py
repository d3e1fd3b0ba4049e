"""The study `extremes`: docs/results/extremes.md tells what it asks and what comes out."""
