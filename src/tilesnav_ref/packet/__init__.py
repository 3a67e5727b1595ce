"""Visibility-event packets: what a vehicle holds, and the bytes that bring it there."""
