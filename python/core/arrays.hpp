#pragma once
// Arrays of numpy. Points are numbered as in the results of a run, by their place in the input; a cloud has an order of
// its own.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/vec3.hpp"

namespace calor::python {

namespace py = pybind11;

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Numbers = py::array_t<std::int64_t>;

inline std::span<const double> values(const Array& array) {
  return {array.data(), static_cast<std::size_t>(array.size())};
}

inline Array array_of(std::span<const double> values) {
  return Array(static_cast<py::ssize_t>(values.size()), values.data());
}
inline Array array_of(std::span<const Vec3> vectors) {
  Array out({static_cast<py::ssize_t>(vectors.size()), py::ssize_t{3}});
  double* to = out.mutable_data();
  for (const Vec3& v : vectors)
    for (int axis = 0; axis < 3; ++axis) *to++ = v[axis];
  return out;
}
inline Numbers array_of(std::span<const std::int64_t> values) {
  return Numbers(static_cast<py::ssize_t>(values.size()), values.data());
}

/// The order of the points of a cloud that one process holds alone.
class Order {
 public:
  /// `id[i]`: number, in the results, of point i of the cloud.
  explicit Order(std::vector<std::int64_t> id) : id_(std::move(id)) {}

  std::int64_t operator[](std::size_t i) const { return id_[i]; }
  std::size_t size() const { return id_.size(); }
  /// From an array with one value a point. Throws py::value_error for one of another size, which `name` tells.
  std::vector<double> to_cloud(const Array& array, const std::string& name) const {
    if (array.ndim() != 1 || values(array).size() != id_.size())
      throw py::value_error(name + " needs " + std::to_string(id_.size()) + " values, one a point");
    std::vector<double> out(id_.size());
    for (std::size_t i = 0; i < id_.size(); ++i) out[i] = array.data()[id_[i]];
    return out;
  }
  template <class Value>
  auto to_results(std::span<const Value> of_cloud) const {
    std::vector<Value> out(id_.size());
    for (std::size_t i = 0; i < id_.size(); ++i) out[id_[i]] = of_cloud[i];
    return array_of(std::span<const Value>(out));
  }
  template <class Value>
  auto to_results(const std::vector<Value>& of_cloud) const {
    return to_results(std::span<const Value>(of_cloud).first(id_.size()));
  }

 private:
  std::vector<std::int64_t> id_;
};

}  // namespace calor::python
