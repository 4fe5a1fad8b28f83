"""The exceptions of the package."""

from __future__ import annotations


class Error(Exception):
    """Every exception of polhode."""


class InputError(Error, ValueError):
    """What was given breaks a rule. The text says what was found and what is allowed.

    file, line: where in the input it stands, or None; message: the text without them.
    """

    def __init__(self, text: str, file: str | None = None, line: int | None = None, message: str | None = None):
        super().__init__(text)
        self.file = file
        self.line = line
        self.message = text if message is None else message


class FileError(Error, OSError):
    """A file cannot be read or written."""


class ComputationError(Error, ArithmeticError):
    """A computation gave no usable answer for input that breaks no rule."""
