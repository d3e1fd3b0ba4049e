"""The study `falsify`: docs/studies/falsify.md tells what it asks and what comes out."""
