#pragma once
// Fields for ParaView, VTK, pyvista and meshio: at every time the points as an unstructured grid (VTU) and the surface
// as polygons (VTP), compressed, one file a rank with a PVTU or PVTP over several ranks; and a PVD over the times of
// each. Names of tags, parts, faces and conditions are in the field data, as arrays of one integer: "tag core" = 1.
// (Not as texts: meshio reads none.)
#include <memory>
#include <string>
#include <vector>

#include "output/field_writer.hpp"

namespace calor {

/// Writes the points alone, as `stem`.vtu, and the surface, as `stem`-surface.vtp, with what a FieldWriter writes
/// along. Throws Error(file). Collective.
void write_cloud(const Cloud& cloud, const std::string& stem, const std::vector<Field>& points);

/// Writes below `folder`/fields, and `folder`/fields.pvd and surface.pvd.
std::unique_ptr<FieldWriter> make_vtu_writer(FieldSetup setup);

}  // namespace calor
