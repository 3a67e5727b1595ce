"""Scans brought together: a growing map with GICP, then an adjustment of all poses at once."""

from tilesnav_ref.registration.register import LEAST_HELD, Registration, register
from tilesnav_ref.registration.settings import RegistrationError, RegistrationSettings

__all__ = ["LEAST_HELD", "Registration", "RegistrationError", "RegistrationSettings", "register"]
