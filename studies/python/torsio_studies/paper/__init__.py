"""The study `paper`: docs/results/paper.md tells what it asks and what comes out."""
