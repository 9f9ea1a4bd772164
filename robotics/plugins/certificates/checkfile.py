"""Check a certificate's file: whether its numbers are in range, and by one of two checkers whether it is true."""

# mypy: disable-error-code="no-untyped-def"
import json
import math

import numpy as np

from robotics.plugins.certificates.checker import RefutedError, check_levels
from robotics.plugins.certificates.statechecker import STATES_FORMAT, check_states


def check(data):
    """Raise RefutedError unless a certificate, a file's bytes or what it holds, is true; return what it holds."""
    try:
        data = json.loads(data) if isinstance(data, bytes) else data
        check_loop(data["loop"])
        if data["format"] == STATES_FORMAT:
            check_states(data)
        else:
            check_levels(data)
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, ArithmeticError) as error:
        raise RefutedError(f"the certificate cannot be read: {error!r}") from None
    return data


def check_loop(k):
    """Raise RefutedError for numbers of a loop that are out of range."""
    groups, numbers = int(k["groups"]), [n for v in k.values() for n in (v if isinstance(v, list) else [v])]
    past = [*k["last"], *(k[n] for n in ("memory", "forgotten", "prompt", "turning"))]
    signed = {"v_weight", "w_weight", "kx", "ky", "kpsi", "last"}
    for holds, wrong in (
        (np.isfinite(np.array(numbers, float)).all(), "a number of the loop is not finite"),
        (min(v for n, v in k.items() if n not in signed) >= 0, "a number of the loop is below 0"),
        (0 < k["speed_low"] <= k["speed_high"] and 0 < k["period"] <= 0.5, "speeds or period are out of range"),
        (groups > 0 <= min(past) and k["memory"] >= 1 and max(past) <= 1000, "what is remembered is out of range"),
        (abs(1 - math.exp(-k["period"] / max(k["smooth"], 1e-9)) - k["fresh"]) < 1e-9, "fresh is not of this smooth"),
        (all(abs(sum(k[n][:groups]) - 1) <= 1e-12 for n in ("v_weight", "w_weight")), "weights must be 1 in all"),
    ):
        if not holds:
            raise RefutedError(wrong)
