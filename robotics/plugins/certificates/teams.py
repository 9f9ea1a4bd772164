"""A certificate of (4.10) over a radio that is late and loses messages: how fast the path parameters agree.

With e_i = s_i − s_0, the delay τ of a message, and what is made of it, ê_j = e_j + min(τ, 0.5 s) e_j':

    e_i⁺ = e_i − T κ ((A + b) e_i − a Σ_j ê_j),   A = a times the number of neighbours that were heard

Where T κ (A + b) <= 1 and min(τ, 0.5 s) κ (A + b) <= 1, both are means of older errors and 0, of which b is the weight
of 0, so that max |e| falls whatever the delays are, as long as they are bounded. docs/explanation/certificate.md has
the theorem and its proof (Halanay's inequality, sampled).
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from robotics.laws.setting import Setting
from robotics.laws.teams.virtual_structure import VirtualStructure
from robotics.plugins.certificates.certificate import CertificateError
from robotics.simulation.safety.assumptions import radio_delay
from robotics.world.radio.channel import BELIEVED
from robotics.world.radio.graph import weights


@dataclass(frozen=True)
class TeamCertificate:
    """What is proven of path parameters that agree by (4.10).

    Attributes:
        rate: max |s_i − s_0| falls as e^(−rate t) at least [1/s], but for ``end``, while no speed meets its limits;
            where one does it does not grow.
        end: What it comes below whatever happens, of the paths' lengths [1].
        delay: The greatest delay that is assumed [s].
        allowed: The greatest with which the proof holds [s]; infinite: any.
    """

    rate: float
    end: float
    delay: float
    allowed: float


def certify_team(law: VirtualStructure, setting: Setting, delay: float | None = None) -> TeamCertificate:
    """Prove that the path parameters of a team agree, or raise CertificateError with what is in the way.

    Args:
        law: Virtual structure with ``variant="virtual", gamma=0``.
        setting: The scenario; its period, graph and timing count.
        delay: The greatest delay [s] of a message, gaps included; by default what one message in 100,000 exceeds.
    """
    if law.variant != "virtual" or law.gamma > 0 or law.coupling != "corrected":
        raise CertificateError(
            "of virtual structure (4.10) is certified, without (4.11): give variant=virtual,gamma=0 and the corrected "
            "coupling"
        )
    if setting.references.joined.shares is not None:
        raise CertificateError(f"{setting.name}: formations by offsets are not certified, only teams of separate paths")
    delay = radio_delay(setting.radio, setting.period) if delay is None else delay
    step, b = setting.period * law.kappa, law.leader
    coupling = float(weights(setting.radio.adjacency(len(setting.robots))).sum(axis=1).max())  # A
    if b == 0:
        raise CertificateError("with leader=0 nothing holds the team to its timing: give leader > 0")
    if step * (coupling + b) > 1:
        raise CertificateError(
            f"kappa must be at most {1 / (setting.period * (coupling + b)):.3g} 1/s with a period of "
            f"{setting.period:g} s; got {law.kappa:g}"
        )
    longest = 1 / (law.kappa * (coupling + b))
    if min(delay, BELIEVED) > longest:
        raise CertificateError(
            f"messages may be {delay:.3g} s old; it is proven up to {longest:.3g} s, which is 1/(kappa (A + leader)): "
            f"give kappa of at most {1 / (min(delay, BELIEVED) * (coupling + b)):.3g} 1/s, or a better radio"
        )
    heard, own = _reference_errors(setting, delay)
    return TeamCertificate(
        rate=-math.log(_factor(step, coupling, b, max(1, math.ceil(delay / setting.period)))) / setting.period,
        end=(coupling * heard * (coupling + b) / b + own / step) / b,
        delay=delay,
        allowed=longest if longest < BELIEVED else math.inf,
    )


def _factor(step: float, coupling: float, b: float, samples: int) -> float:
    """r with r = 1 − Tκ(A + b) + Tκ A r^(−N), by which max |e| falls in a period."""
    least = (coupling / (coupling + b)) ** (1 / samples)  # below it ê may be greater than r^(−N) e

    def excess(r: float) -> float:
        return r - (1 - step * (coupling + b)) - step * coupling * r**-samples

    if coupling == 0:
        return 1 - step * b
    return least if excess(least) >= 0 else float(brentq(excess, least, 1.0, xtol=1e-14))


def _reference_errors(setting: Setting, delay: float) -> tuple[float, float]:
    """By what a prediction of s_0 is off, the differences between robots included, and by what a step of it is.

    Until the first reference is at its end, where it stops at once.
    """
    times = np.arange(int(setting.references.ends.min() / setting.period)) * setting.period
    reference, lengths = setting.references.sampled(times), setting.references.joined.lengths
    s, rate = reference.s / lengths, reference.v / lengths
    heard = np.ptp(s, axis=1).max() if len(setting.robots) > 1 else 0.0
    for n in range(1, min(math.ceil(delay / setting.period), len(times) - 1) + 1):
        told = s[:-n] + min(n * setting.period, BELIEVED) * rate[:-n]
        heard = max(heard, float(np.abs(s[n:, :, None] - told[:, None, :]).max()))
    own = float(np.abs(s[1:] - s[:-1] - setting.period * rate[:-1]).max())
    return float(heard), own
