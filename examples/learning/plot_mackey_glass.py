"""
Mackey-Glass: a chaotic series, predicted
=========================================

Jang's benchmark: x(t + 6) from x(t - 18), x(t - 12), x(t - 6) and x(t); 500 pairs to learn from, the next 500 to
check, two bells for each input, 16 rules. The error on the pairs to check falls as that on the others does: nothing is
learned by heart.
"""

# sphinx_gallery_thumbnail_number = 2
from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure

import anfis
import fuzzy


def mackey_glass(length, step=0.1, delay=17.0):
    """x' = 0.2 x(t - τ)/(1 + x(t - τ)¹⁰) - 0.1 x from x(0) = 1.2, by Runge-Kutta of order 4, once a unit of time."""
    lag = round(delay / step)
    x = np.zeros(round(length / step) + 1)
    x[0] = 1.2

    def slope(now, then):
        return 0.2 * then / (1 + then**10) - 0.1 * now

    for k in range(len(x) - 1):
        then = x[k - lag] if k >= lag else 0.0
        later = x[k - lag + 1] if k >= lag else 0.0
        a = slope(x[k], then)
        b = slope(x[k] + step * a / 2, (then + later) / 2)
        c = slope(x[k] + step * b / 2, (then + later) / 2)
        d = slope(x[k] + step * c, later)
        x[k + 1] = x[k] + step * (a + 2 * b + 2 * c + d) / 6
    return x[:: round(1 / step)]


series = mackey_glass(1200)
t = np.arange(118, 1118)
x, y = np.stack([series[t - 18], series[t - 12], series[t - 6], series[t]], axis=1), series[t + 6]
start = fuzzy.identify(x[:500], y[:500], "grid", mfs=2, kind="gbellmf")
start = replace(start, out_of_range="ignore")  # the checking pairs reach a little beyond those to learn from
trained = anfis.train(start, x[:500], y[:500], anfis.Options(epochs=40), check=(x[500:], y[500:]))
figure = anfis.plot_training(trained.history)

# %%
# The prediction of what it has not learned from, and its error. NDEI is the error over the series' standard deviation.

said = trained.system(x[500:])[:, 0]
print(f"NDEI on the checking pairs: {np.sqrt(np.mean((said - y[500:]) ** 2)) / np.std(y[500:]):.4f}")
with fuzzy.style():
    prediction = Figure(figsize=(4.6, 3.6), layout="constrained")
    above, below = prediction.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    above.plot(t[500:] + 6, y[500:], "-k", label="series")
    above.plot(t[500:] + 6, said, "--C1", label="predicted 6 ahead")
    below.plot(t[500:] + 6, 1e3 * (said - y[500:]), "-C0", linewidth=0.8)
    above.set_ylabel("x")
    below.set_ylabel("error [10⁻³]")
    below.set_xlabel("t")
    prediction.legend(loc="outside upper center", ncols=2)
