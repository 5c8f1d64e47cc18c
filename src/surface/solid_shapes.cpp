#include "surface/solid_shapes.hpp"

namespace calor {
SolidShape solid_file(), solid_rectangle(), solid_polygon(), solid_disc(), solid_annulus(), solid_sector(), solid_box(),
    solid_cylinder(), solid_tube(), solid_cone(), solid_sphere(), solid_shell(), solid_ellipsoid(), solid_extrusion(),
    solid_revolution();

Registry<SolidShape>& solid_shapes() {
  static Registry<SolidShape> all = {solid_file(),      solid_rectangle(), solid_polygon(),   solid_disc(),
                                     solid_annulus(),   solid_sector(),    solid_box(),       solid_cylinder(),
                                     solid_tube(),      solid_cone(),      solid_sphere(),    solid_shell(),
                                     solid_ellipsoid(), solid_extrusion(), solid_revolution()};
  return all;
}

}  // namespace calor
