"""The commands of `torsio`, some in each file; `torsio.apps.cli` puts them together."""
