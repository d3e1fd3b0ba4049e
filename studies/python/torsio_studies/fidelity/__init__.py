"""The study `fidelity`: docs/results/fidelity.md tells what it asks and what comes out."""
