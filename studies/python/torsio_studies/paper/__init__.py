"""The study `paper`: docs/studies/paper.md tells what it asks and what comes out."""
