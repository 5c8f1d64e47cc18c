// Steps through a case in a loop of its own and prints the temperatures of its probes: embedding CASE SECONDS STEPS
#include <petscsys.h>

#include <cstdio>
#include <cstdlib>

#include "app/model.hpp"
#include "app/schema.hpp"
#include "output/probes.hpp"
#include "solve/integrator.hpp"

void march(const char* file, double end, int steps) {
  const calor::Case c = calor::Case::read(file, calor::schema());
  calor::Phases phases;
  const calor::Model model = calor::build_model(c, PETSC_COMM_WORLD, phases);
  const calor::Probes probes(c, *model.cloud, &model.system->dofs());
  calor::State state = calor::start(model).state;
  const auto integrator = calor::make_integrator(c, *model.system, state);
  for (int n = 1; n <= steps; ++n) {
    integrator->advance(*model.system, state, end * n / steps, [](const calor::State&) { return true; });
    std::printf("%g s", state.t);
    for (const double T : probes.sample(model.system->temperatures(state.T))) std::printf("  %.2f K", T);
    std::printf("\n");
  }
}

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  PetscInitializeNoArguments();  // MPI and PETSc belong to the program that calls
  int code = 0;
  try {
    march(argv[1], std::atof(argv[2]), std::atoi(argv[3]));
  } catch (const calor::Error& e) {  // says file, line, value and cure
    std::fprintf(stderr, "%s\n", e.what());
    code = static_cast<int>(e.fault());
  }
  PetscFinalize();
  return code;
}
