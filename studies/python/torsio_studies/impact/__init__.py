"""The study `impact`: docs/results/impact.md tells what it asks and what comes out."""
