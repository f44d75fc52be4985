"""The fixtures of judging.py, for pytest."""

from judging import room

__all__ = ["room"]
