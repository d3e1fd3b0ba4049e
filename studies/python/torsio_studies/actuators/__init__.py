"""The study `actuators`: docs/results/actuators.md tells what it asks and what comes out."""
