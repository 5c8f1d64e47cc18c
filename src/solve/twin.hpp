#pragma once
// The manufactured twin of a case: the same body, materials and conditions, with the solution put to a smooth formula.
// What the heat equation lacks then goes in as sources in the cells and fluxes through the facets, so that the error of
// a run is known. Roache, J. Fluids Eng. 124 (2002) 4 (method of manufactured solutions).
#include <memory>
#include <optional>
#include <vector>

#include "boundary/conditions.hpp"
#include "case/case.hpp"
#include "case/schema.hpp"
#include "cloud/cloud.hpp"
#include "material/material_field.hpp"
#include "source/source.hpp"

namespace calor {

struct Twin {
  Function T;                     ///< everywhere; it may bend where parts meet
  std::vector<Function> of_part;  ///< the same in every part, smooth beyond it; none of a body of one part
};

/// The solution of [twin]; nothing where the case has none. Refuses solutions whose heat crosses a crack, and bodies
/// that have no twin: with points off their walls. Collective; throws Error.
std::optional<Twin> read_twin(const Case& c, const Cloud& cloud);

/// Gives all prescribed temperatures, and those of the start, the values of the solution.
void prescribe_twin(const Twin& twin, const Cloud& cloud, Conditions& conditions, std::vector<double>& T_start);

/// What is lacking, as a source called "twin": in the cells rho c dT/dt - div (k R grad T), through the facets
/// n . k R grad T less the fluxes of the conditions at T. Refuses bodies of several parts without solutions of their
/// own, and conductivities that jump within a part. Conditions and cloud must outlive it. Collective; throws Error.
std::unique_ptr<Source> make_twin_source(const Case& c, const Twin& twin, const Cloud& cloud,
                                         const Conditions& conditions, const MaterialField& body);

void declare_twin(Schema& schema);

}  // namespace calor
