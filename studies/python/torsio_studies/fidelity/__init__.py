"""The study `fidelity`: docs/studies/fidelity.md tells what it asks and what comes out."""
