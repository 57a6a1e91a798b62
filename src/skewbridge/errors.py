"""The one exception of the package that a caller is expected to show to the user."""


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
