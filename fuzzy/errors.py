"""The family of errors that a user can mend: one class at each boundary, all of them ValueErrors."""


class InputError(ValueError):
    """Something given cannot be used. The message says where, what, and what is accepted.

    A command line prints the message and exits with 2; any other exception there is a bug.
    """
