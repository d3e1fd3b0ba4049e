"""`python -m torsio_hardware`."""

from torsio_hardware.cli import app

app(prog_name="torsio-hardware")
