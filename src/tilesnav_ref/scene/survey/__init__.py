"""Scenes from point clouds: what a survey has measured, and what it has not."""
