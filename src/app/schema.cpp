#include "app/schema.hpp"

#include "boundary/conditions.hpp"
#include "case/case.hpp"
#include "cloud/cracks.hpp"
#include "cloud/points.hpp"
#include "conduction/method.hpp"
#include "material/material_field.hpp"
#include "output/expect.hpp"
#include "output/observer.hpp"
#include "output/probes.hpp"
#include "output/thermal_stress.hpp"
#include "output/weld.hpp"
#include "solve/initial.hpp"
#include "solve/integrator.hpp"
#include "solve/twin.hpp"
#include "source/source.hpp"

namespace calor {

Schema schema() {
  Schema s;
  declare_case(s);
  declare_methods(s);
  declare_cloud(s);
  declare_cracks(s);
  declare_materials(s);
  declare_initial(s);
  declare_boundaries(s);
  declare_sources(s);
  declare_time(s);
  declare_twin(s);
  declare_output(s);
  declare_probes(s);
  declare_weld(s);
  declare_stress(s);
  observers().declare(s);
  declare_expect(s);
  declare_studies(s);
  return s;
}

}  // namespace calor
