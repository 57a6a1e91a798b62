"""The exceptions of the package that a command shows to the user as one sentence."""


class InputError(ValueError):
    """Bad input, found before any work started.

    The message names the field (or file and line), the value given and the limit. The command
    line prints it alone and exits with 2.

    Attributes:
        details: Machine-readable particulars, added to the JSON answer of a command.
    """

    def __init__(self, message: str, **details: object) -> None:
        super().__init__(message)
        self.details = details


class SolutionError(RuntimeError):
    """A solution could not go on to its end.

    The command line prints the message alone and exits with 1.
    """
