// The compiled half of calor.core: python/calor/core.py has the functions that users call, with their documentation.
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "arrays.hpp"
#include "callbacks.hpp"
#include "material/library.hpp"
#include "model.hpp"
#include "session.hpp"

namespace {

using namespace calor;
using namespace calor::python;

/// Errors of the library are the exceptions of the package, which know line and key; but those of functions of Python
/// are their own.
void raise_error(std::exception_ptr held) {
  try {
    std::rethrow_exception(held);
  } catch (const Error& e) {
    if (auto raised = take_raised()) return raised->restore();
    const py::object error =
        py::module_::import("calor.command").attr("error_of")(static_cast<int>(e.fault()), e.what());
    PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(error.ptr())), error.ptr());
  }
}

/// A material of the library.
class LibraryEntry {
 public:
  explicit LibraryEntry(const std::string& name) : material_(find_in_library(name)) {
    if (!material_) throw py::key_error(name);
    properties_ = material_->properties();
  }
  const LibraryMaterial& material() const { return *material_; }
  Array conductivity(const Array& T) const { return at(properties_.conductivity, T); }
  Array density(const Array& T) const { return at(*properties_.density, T); }
  Array specific_heat(const Array& T) const { return at(*properties_.specific_heat, T); }

 private:
  static Array at(const Function& f, const Array& T) {
    Array out(std::vector<py::ssize_t>(T.shape(), T.shape() + T.ndim()));
    const std::vector<Vec3> x(T.size());
    f.evaluate({.x = x, .T = values(T)}, {out.mutable_data(), static_cast<std::size_t>(out.size())});
    return out;
  }

  const LibraryMaterial* material_;
  SimpleProperties properties_;
};

void add_materials(py::module_& m) {
  m.def("material_names", [] {
    std::vector<std::string> names;
    for (const LibraryMaterial& material : material_library()) names.push_back(material.name);
    return names;
  });
  py::class_<LibraryEntry>(m, "Material")
      .def(py::init<const std::string&>())
      .def_property_readonly("name", [](const LibraryEntry& e) { return e.material().name; })
      .def_property_readonly("range",
                             [](const LibraryEntry& e) { return std::pair(e.material().low, e.material().high); })
      .def_property_readonly("sources",
                             [](const LibraryEntry& e) {
                               py::dict all;
                               all["conductivity"] = e.material().conductivity.source;
                               all["density"] = e.material().density.source;
                               all["specific_heat"] = e.material().specific_heat.source;
                               if (e.material().melting) all["melting"] = e.material().melting->source;
                               return all;
                             })
      .def_property_readonly("melting",
                             [](const LibraryEntry& e) -> py::object {
                               const auto& melting = e.material().melting;
                               if (!melting) return py::none();
                               return py::make_tuple(melting->latent.heat, melting->latent.solidus,
                                                     melting->latent.liquidus);
                             })
      .def("conductivity", &LibraryEntry::conductivity)
      .def("density", &LibraryEntry::density)
      .def("specific_heat", &LibraryEntry::specific_heat);
}

void add_model(py::module_& m) {
  using Strings = std::vector<std::string>;
  py::class_<CaseModel>(m, "Model")
      .def(py::init<const std::string&, const Strings&, const py::dict&>())
      .def_property_readonly("dimension", [](const CaseModel& c) { return c.cloud().dimension; })
      .def_property_readonly("points", [](const CaseModel& c) { return c.order().to_results(c.cloud().x); })
      .def_property_readonly("volumes", [](const CaseModel& c) { return c.order().to_results(c.cloud().volume); })
      .def_property_readonly("spacing", [](const CaseModel& c) { return c.order().to_results(c.cloud().metric); })
      .def_property_readonly("areas", [](const CaseModel& c) { return c.order().to_results(c.cloud().area); })
      .def_property_readonly("faces", [](const CaseModel& c) { return c.cloud().faces; })
      .def_property_readonly("facets", &CaseModel::facets)
      .def_property_readonly("parts", &CaseModel::parts)
      .def_property_readonly("part", &CaseModel::part)
      .def_property_readonly("notes", &CaseModel::notes)
      .def_property_readonly("accounts", &CaseModel::accounts)
      .def_property_readonly("prescribed", &CaseModel::prescribed)
      .def_property_readonly("start", &CaseModel::start)
      .def_property_readonly("dofs_are_temperatures", &CaseModel::dofs_are_temperatures)
      .def("temperatures", &CaseModel::temperatures)
      .def("dofs", &CaseModel::dofs)
      .def("shape_functions", &CaseModel::shape_functions)
      .def("weights", &CaseModel::weights)
      .def("conductivity", &CaseModel::conductivity)
      .def("heat_capacity", &CaseModel::heat_capacity)
      .def("energy", &CaseModel::energy)
      .def("capacity", &CaseModel::capacity)
      .def("rate", &CaseModel::rate)
      .def("residual", &CaseModel::residual)
      .def("jacobian", &CaseModel::jacobian)
      .def("heat_flux", &CaseModel::heat_flux)
      .def("heat_flows", &CaseModel::heat_flows)
      .def("solve", &CaseModel::solve)
      .def("march", &CaseModel::march);
}

}  // namespace

PYBIND11_MODULE(_core, m) {
  py::register_exception_translator(raise_error);
  quiet_log();
  add_materials(m);
  add_model(m);
  m.def("run", &run_case);
}
