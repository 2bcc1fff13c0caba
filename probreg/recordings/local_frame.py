"""The common frame under its former address; it is `probreg.sensors.frame`."""

from probreg.sensors.frame import LocalFrame

__all__ = ["LocalFrame"]
