"""Scenes from point clouds: what a survey has measured, and what it has not."""

from tilesnav_ref.survey.settings import SurveySettings
from tilesnav_ref.survey.source import open_scene

__all__ = ["SurveySettings", "open_scene"]
