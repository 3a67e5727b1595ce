"""Builder of the conformance cases; it shares no code with any encoder or validator."""
