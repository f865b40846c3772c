"""The errors that symgen raises: one tree, one line each, written for the person who reads them."""


class SymgenError(Exception):
    """Root of every error that symgen raises on purpose.

    The message says in one line what went wrong, where, and what is accepted.
    """


class RobotError(SymgenError):
    """A robot file, or a robot built in Python, is not a valid mechanism."""


class ExpressionError(RobotError):
    """A text in a robot file is not an expression of the safe grammar."""


class LogError(SymgenError):
    """A measured log cannot be read, or does not belong to the robot."""


class ParameterError(SymgenError):
    """Parameter values are missing, unknown, or not finite."""


class PackageError(SymgenError):
    """A generated package cannot be written, read, or is not what it should be."""


class BuildError(SymgenError):
    """The C sources of a model could not be compiled or loaded."""


class IdentificationError(SymgenError):
    """The data cannot determine the parameters that were asked for."""


class SymgenWarning(UserWarning):
    """Something in the input is allowed but probably not meant."""
