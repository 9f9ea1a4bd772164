"""Lists and numbers of things, as sentences have them."""

from collections.abc import Iterable


def listed(items: Iterable[str], word: str = "and") -> str:
    """Join items as a sentence lists them: "a, b and c"; there must be one at least.

    >>> listed(["near"]), listed(["near", "far"]), listed(["near", "middle", "far"], "or")
    ('near', 'near and far', 'near, middle or far')
    """
    *before, last = items
    return f"{', '.join(before)} {word} {last}" if before else last


def counted(number: int, what: str) -> str:
    """Say how many things there are: "1 rule", "2 rules"."""
    return f"{number} {what}{'' if number == 1 else 's'}"


def split_list(text: str) -> list[str]:
    """The items of a list with commas, as options take it; empty ones are left out.

    >>> split_list("fuzzy, lyapunov,")
    ['fuzzy', 'lyapunov']
    """
    return [item.strip() for item in text.split(",") if item.strip()]
