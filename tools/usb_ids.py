"""The knob's USB vendor and product id, from the C++ header, for where they must stand in full.

``./dev generate`` writes them into udev's rule and the documents.
"""

from __future__ import annotations

import re
from pathlib import Path

TREE = Path(__file__).parent.parent
HEADER = TREE / "firmware" / "protocol" / "usb_ids.hpp"
RULE = TREE / "sdk" / "60-torsio.rules"


def ids() -> tuple[str, str]:
    """Return vendor and product id as udev and ``lsusb`` write them, four digits each."""
    text = HEADER.read_text(encoding="utf-8")
    vendor, product = (
        int(re.findall(rf"{name} = 0x([0-9A-Fa-f]+);", text)[0], 16)
        for name in ("usb_vendor_id", "usb_product_id")
    )
    return f"{vendor:04x}", f"{product:04x}"


def places() -> list[Path]:
    """Return the files that state the ids: udev's rule and every document."""
    return [RULE, TREE / "README.md", *sorted((TREE / "docs").glob("**/*.md"))]


def with_ids(text: str) -> str:
    """Return a file's text with the ids as they must be."""
    vendor, product = ids()
    text = re.sub(r'(idVendor}==")[0-9a-f]{4}"', rf'\g<1>{vendor}"', text)
    text = re.sub(r'(idProduct}==")[0-9a-f]{4}"', rf'\g<1>{product}"', text)
    return re.sub(r"\b[0-9a-f]{4}:[0-9a-f]{4}\b", f"{vendor}:{product}", text)
