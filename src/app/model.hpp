#pragma once
// A case put together: cloud, conditions, discretisation, material, heat system; ready to be checked or run.
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "case/case.hpp"
#include "cloud/cloud.hpp"
#include "conduction/method.hpp"
#include "output/report.hpp"
#include "solve/heat_system.hpp"

namespace calor {

struct Model {
  const Case& description;
  std::unique_ptr<Cloud> cloud;  // at a fixed address: the system refers to it
  MethodReport weights;
  std::vector<std::string> notes;
  std::unique_ptr<HeatSystem> system;
  std::vector<double> T_start;  ///< owned points, K, walls not imposed
  /// Areas on which heat flows by the sections of [boundary.*] that have a flux, m^2.
  std::vector<std::pair<std::string, double>> heated_areas = {};
  TemperatureRange range = {};  ///< that the material's curves are sampled over
};

/// Builds everything up to the heat system. Collective; throws Error.
Model build_model(const Case& c, MPI_Comm comm, Phases& phases);

/// The materials of a case in the body and discretisation of a model of another case, which differ in conductivities
/// alone. Collective; throws Error.
std::vector<MaterialField> materials_of(const Case& c, const Model& model);

struct Start {
  State state;                         ///< at t = 0, walls imposed
  std::vector<double> E_before_walls;  ///< owned points, J: the energy balance counts from here
};

/// The state in which a run begins. Refuses material properties that are wrong from the start. Collective.
Start start(const Model& model);

/// Is the case steady (a [steady] section) or transient ([time])? Throws Error when it is neither or both.
bool is_steady(const Case& c);

}  // namespace calor
