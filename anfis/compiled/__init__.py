"""Learning compiled for speed: float64 on the CPU. :mod:`anfis.network` is the same in torch."""
