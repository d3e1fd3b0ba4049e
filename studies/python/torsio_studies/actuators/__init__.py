"""The study `actuators`: docs/studies/actuators.md tells what it asks and what comes out."""
