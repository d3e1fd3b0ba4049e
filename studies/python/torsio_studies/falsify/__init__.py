"""The study `falsify`: docs/results/falsify.md tells what it asks and what comes out."""
