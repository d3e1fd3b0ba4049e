"""Fill in ``id`` and ``hex`` of the rows of ``reports.json`` with ``struct`` alone.

Write a new row with ``report`` and ``values`` by hand, then run
``python -m tests.golden.make_reports``. Choose values that differ from field to field and byte to
byte, and floats that are exact in 32 bits. Then no two mistakes cancel out.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from tests.python import wire

GOLDEN = Path(__file__).parent / "reports.json"


def reports_json(rows: list[dict[str, Any]]) -> str:
    """Give the text of the golden file with these reports and values."""
    filled = [
        {
            "report": row["report"],
            "id": wire.REPORTS[row["report"]].id,
            "values": row["values"],
            "hex": wire.encode(row["report"], row["values"]).hex(),
        }
        for row in rows
    ]
    return "[\n" + ",\n".join("  " + json.dumps(row) for row in filled) + "\n]\n"


if __name__ == "__main__":
    GOLDEN.write_text(reports_json(json.loads(GOLDEN.read_text())))
