"""The study `design`: docs/studies/design.md tells what it asks and what comes out."""
