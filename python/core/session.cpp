#include "session.hpp"

#include <petscsys.h>
#include <pybind11/pybind11.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "base/petsc.hpp"
#include "base/single_process.hpp"

namespace py = pybind11;

namespace calor::python {
namespace {

bool has_started = false;

void end_session() {
  if (!petsc::is_finalized()) PetscFinalize();
}

}  // namespace

void start_session() {
  if (has_started) return;
  PetscBool is_running = PETSC_FALSE;
  PetscInitialized(&is_running);
  if (!is_running) {
    const SingleProcess alone;
    petsc::check(PetscInitializeNoArguments());
    petsc::check(PetscPopSignalHandler());  // signals are Python's
    py::module_::import("atexit").attr("register")(py::cpp_function(end_session));
  }
  petsc::collect_errors();
  has_started = true;
}

void quiet_log() {
  spdlog::set_default_logger(spdlog::stderr_color_mt("calor"));
  spdlog::set_pattern("%v");
  spdlog::set_level(spdlog::level::debug);  // for the log in the folder of a run
  spdlog::default_logger()->sinks().front()->set_level(spdlog::level::warn);
}

}  // namespace calor::python
