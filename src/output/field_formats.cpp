#include "output/field_writer.hpp"
#include "output/vtu.hpp"
#include "output/xdmf.hpp"

namespace calor {

Registry<FieldFormat>& field_formats() {
  static Registry<FieldFormat> all{
      {"vtu",
       "files of VTK, one a rank, listed in fields.pvd and surface.pvd",
       make_vtu_writer,
       {"fields.pvd", "surface.pvd", "fields/*.*vtu", "fields/*.*vtp"}},
      {"xdmf",
       "HDF5 written by all ranks together, one file a time, listed in fields.xdmf and surface.xdmf",
       make_xdmf_writer,
       {"fields.xdmf", "surface.xdmf", "fields/*.h5"}}};
  return all;
}

}  // namespace calor
