#pragma once
// Functions of Python in a case.
#include <pybind11/pybind11.h>

#include <optional>

#include "case/case.hpp"

namespace calor::python {

/// {name: (f, of place?, of time?, of temperature?)}: f(x, t, T) gets the places, (n, 3) in m, the time, s, and the
/// temperatures, (n) in K or empty, and returns an array of n values in SI units.
Callbacks callbacks_of(const pybind11::dict& functions);

/// What the last call of a function raised, if it did: the library makes an Error of it, which every rank can throw.
/// Nothing the second time.
std::optional<pybind11::error_already_set> take_raised();

}  // namespace calor::python
