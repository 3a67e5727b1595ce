"""Packets: what travels to a vehicle, with the geometry."""
