"""The Mackey-Glass series as Jang's ANFIS paper and MATLAB's mgdata.dat have it."""

import numpy as np


def series(count: int = 1201) -> np.ndarray:
    """``count`` values at 1 s steps: x' = 0.2 x(t−17)/(1 + x(t−17)¹⁰) − 0.1 x by Runge-Kutta with h = 0.1.

    x(0) = 1.2 and 0 before; the delayed value is held over a step and comes from a ring buffer of 170 slots that keeps
    the value after each step, so that the delay is 169 steps and x(0) itself is never fed back.
    """

    def slope(x: float, delayed: float) -> float:
        return 0.2 * delayed / (1 + delayed**10) - 0.1 * x

    h, x = 0.1, 1.2
    past: list[float] = []  # past[k] is x after k + 1 steps
    values = []
    for step in range((count - 1) * 10 + 1):
        if step % 10 == 0:
            values.append(x)
        delayed = past[step - 170] if step >= 170 else 0.0
        k1 = slope(x, delayed)
        k2 = slope(x + h / 2 * k1, delayed)
        k3 = slope(x + h / 2 * k2, delayed)
        k4 = slope(x + h * k3, delayed)
        x += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        past.append(x)
    return np.array(values)


def pairs() -> tuple[np.ndarray, np.ndarray]:
    """[x(t−18), x(t−12), x(t−6), x(t)] → x(t+6) for t = 118 ... 1117: inputs (1000, 4), targets (1000,)."""
    x, t = series(), np.arange(118, 1118)
    return np.stack([x[t - 18], x[t - 12], x[t - 6], x[t]], axis=1), x[t + 6]
