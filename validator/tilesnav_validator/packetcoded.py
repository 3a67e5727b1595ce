"""Bodies of the coded codec."""

from __future__ import annotations

from tilesnav_validator.packetparts import BodyError, Part, Parts


def decode(body: memoryview, held: Parts, object_count: int) -> dict[int, Part]:
    """Refuse a coded body, which this validator does not read."""
    raise BodyError("body", f"{len(body)} coded bytes, {len(held)} of {object_count} objects held", "codec 0")
