#include "callbacks.hpp"

#include <algorithm>
#include <utility>

#include "arrays.hpp"

namespace calor::python {
namespace {

std::optional<py::error_already_set> raised;

void call(const py::object& f, const Arguments& args, std::span<double> out) {
  raised.reset();
  try {
    std::ranges::copy(values(f(array_of(args.x), args.t, array_of(args.T)).cast<Array>()), out.begin());
  } catch (const py::error_already_set& e) {
    raised = e;
    throw;
  }
}

}  // namespace

Callbacks callbacks_of(const py::dict& functions) {
  Callbacks all;
  for (const auto& [key, entry] : functions) {
    const auto parts = entry.cast<py::tuple>();
    const Function::Dependence on{
        .place = parts[1].cast<bool>(), .time = parts[2].cast<bool>(), .temperature = parts[3].cast<bool>()};
    const auto evaluate = [f = py::object(parts[0])](const Arguments& args, std::span<double> out) {
      call(f, args, out);
    };
    all.emplace(key.cast<std::string>(), Function::Callback{.evaluate = evaluate, .on = on});
  }
  return all;
}

std::optional<py::error_already_set> take_raised() { return std::exchange(raised, {}); }

}  // namespace calor::python
