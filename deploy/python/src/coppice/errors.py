"""The one error that this package raises for what comes from outside."""


class CoppiceError(Exception):
    """A file, an environment or an argument is not what is expected; the message says which and how."""
