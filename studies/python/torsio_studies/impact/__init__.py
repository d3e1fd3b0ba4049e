"""The study `impact`: docs/studies/impact.md tells what it asks and what comes out."""
