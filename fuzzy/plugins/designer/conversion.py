"""A membership function of another type at the same place and of the same width.

Between the types stands a trapezoid (:mod:`fuzzy.profile`): each class says which one stands for its functions, and
which of its functions is fitted to one.
"""

from fuzzy.membership import membership_function
from fuzzy.membershipfunction import MATLAB_NAMES, MembershipFunction


def converted(function: MembershipFunction, kind: str, universe: tuple[float, float]) -> MembershipFunction:
    """``function`` as the function of the MATLAB name ``kind``, over ``universe`` (lowest and highest value).

    - Feet and shoulders stay where both types have them. A triangle's peak is the middle of the core. Curves keep
      the points of degree 0.5, about the middle of the core if they are symmetric.
    - A side that is open (linzmf to the left, say) is closed at the end of ``universe``, with the value 1 there.
    - A function with two sides becomes the one with one side that it has: linsmf, smf the left, linzmf, zmf the right,
      sigmf the one nearer the middle of the universe.

    Raises MembershipError for an unknown name, and for functions that state no profile.
    """
    if kind == type(function).matlab:
        return function
    if kind not in MATLAB_NAMES:
        return membership_function(kind, ())  # raises, with the names that there are
    low, high = universe
    new = MATLAB_NAMES[kind]
    parameters = new.fitted(function.profile((high - low) or 1.0).closed(low, high))
    # Computed widths and slopes need no more digits than a designer reads.
    tidy = [p if role == "location" else float(f"{p:.6g}") for p, role in zip(parameters, new.roles, strict=True)]
    return new(*tidy)
