#include "session.hpp"

#include <petscsys.h>
#include <pybind11/pybind11.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <cstdlib>

#include "base/petsc.hpp"

namespace py = pybind11;

namespace calor::python {
namespace {

bool has_started = false;

/// Nobody has launched this process: Open MPI needs neither its helper process nor folders for several processes.
void prepare_single_process() {
  if (std::getenv("PMIX_RANK")) return;
  setenv("OMPI_MCA_ess_singleton_isolated", "1", 0);
  setenv("OMPI_MCA_orte_create_session_dirs", "0", 0);
}

void end_session() {
  if (!petsc::is_finalized()) PetscFinalize();
}

}  // namespace

void start_session() {
  if (has_started) return;
  PetscBool is_running = PETSC_FALSE;
  PetscInitialized(&is_running);
  if (!is_running) {
    prepare_single_process();
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
