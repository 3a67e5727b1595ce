"""Visibility-event packets."""
