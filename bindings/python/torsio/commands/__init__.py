"""The commands of `torsio`, some in each file; `torsio.cli` puts them together."""
