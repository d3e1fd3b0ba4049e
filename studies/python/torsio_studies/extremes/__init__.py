"""The study `extremes`: docs/studies/extremes.md tells what it asks and what comes out."""
