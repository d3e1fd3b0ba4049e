"""The study `design`: docs/results/design.md tells what it asks and what comes out."""
