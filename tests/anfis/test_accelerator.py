"""Learning and inference on a CUDA device give what they give on the CPU."""

import numpy as np
import pytest
import torch

import anfis
import fuzzy
from anfis import Options
from tests.anfis.training_problem import CHECK, FIS, TRAINED, X, Y

pytestmark = pytest.mark.skipif(not torch.cuda.is_available(), reason="no CUDA device")

# Sums of another order of additions differ in their last digits, which epochs of training make larger.
CLOSE = {"float64": 1e-6, "float32": 2e-2}


@pytest.mark.parametrize("dtype", CLOSE)
@pytest.mark.parametrize("batch", [0, 17])
@pytest.mark.parametrize("method", [*TRAINED, "least-squares"])
def test_errors_follow_those_of_the_cpu(method, batch, dtype):
    runs = [
        anfis.train(FIS, X, Y, Options(method=method, epochs=6, batch=batch, dtype=dtype, device=device), check=CHECK)
        for device in ("cpu", "cuda")
    ]
    cpu, cuda = ([(row.train, row.check) for row in run.history] for run in runs)
    assert len(cpu) > 1 or method == "least-squares"
    np.testing.assert_allclose(cuda, cpu, rtol=CLOSE[dtype])
    np.testing.assert_allclose(runs[1].system(X), runs[0].system(X), rtol=CLOSE[dtype], atol=CLOSE[dtype])


@pytest.mark.parametrize("kind", ["gaussmf", "gbellmf", "trapmf", "pimf", "psigmf", "dsigmf"])
def test_a_system_of_tensors_on_the_device(kind):
    fis = fuzzy.identify(X, Y, "grid", mfs=2, kind=kind)
    found = fis(torch.tensor(X, device="cuda"))
    assert found.device.type == "cuda"
    np.testing.assert_allclose(found.cpu(), fis(X), atol=1e-9)


def test_gradients_reach_the_inputs():
    x = torch.tensor(X, device="cuda", requires_grad=True)
    fitted = anfis.train(FIS, X, Y, Options(method="least-squares")).system
    fitted(x).sum().backward()
    cpu = torch.tensor(X, requires_grad=True)
    fitted(cpu).sum().backward()
    np.testing.assert_allclose(x.grad.cpu(), cpu.grad, atol=1e-9)
