"""The one exception for input that cannot be used."""


class InputError(ValueError):
    """Bad input, explained in one sentence.

    The message says what was expected, what came, and what to do. The command line prints it
    on standard error and exits with status 2.
    """
