"""
ANFIS learns sinc
=================

Jang's first example: sin(x)/x · sin(y)/y on 121 points, four bells for each input, 16 rules. Hybrid learning, as he
has it, and second order, from the same start. The points between those say which network is kept: second order
ends with no error where it has learned, and with a greater one between.
"""

# sphinx_gallery_thumbnail_number = 2
import numpy as np

import anfis
import fuzzy


def samples(side):
    """The function on a grid."""
    x = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    return x, np.prod(np.sinc(x / np.pi), axis=1)


x, f = samples(np.linspace(-10, 10, 11))
between = samples(np.linspace(-9, 9, 10))
start = fuzzy.identify(x, f, "grid", mfs=4, kind="gbellmf", input_names=["x", "y"], output_names=["f"])
for method in ("hybrid", "second-order"):
    trained = anfis.train(start, x, f, anfis.Options(method=method, epochs=60), check=between)
    print(f"{method}: epoch {trained.best} is kept, RMSE {trained.rmse:.4f}, between {trained.check_rmse:.4f}")
figure = anfis.plot_training(trained.history)

# %%
# What second order has learned when it is stopped there:

surface = fuzzy.plot_surface(trained.system)
