// The system of benchmarks/inference.py in fuzzylite's C++ library, point by point, as its own benchmarks do.
#include <cstddef>
#include <fl/Headers.h>

// A description in fuzzylite's language becomes an engine.
extern "C" void *make(const char *description) {
    fl::fuzzylite::setMachEps(0.0);  // by default it drops rules that fire with less than 1e-6
    return fl::FllImporter().fromString(description);
}

// x (n, inputs), y (n)
extern "C" void infer(void *made, std::ptrdiff_t n, const double *x, double *y) {
    fl::Engine *engine = static_cast<fl::Engine *>(made);
    const std::size_t inputs = engine->numberOfInputVariables();
    for (std::ptrdiff_t p = 0; p < n; p++) {
        for (std::size_t i = 0; i < inputs; i++) engine->getInputVariable(i)->setValue(x[p * inputs + i]);
        engine->process();
        y[p] = engine->getOutputVariable(0)->getValue();
    }
}
