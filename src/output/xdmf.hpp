#pragma once
// Fields for ParaView and VisIt with few files however many ranks there are: the numbers in HDF5, written by all ranks
// together and compressed, and what they are in XDMF. For Python: h5py.
#include <memory>

#include "output/field_writer.hpp"

namespace calor {

/// Writes `folder`/fields.xdmf and surface.xdmf, which list the times; below `folder`/fields a file NAME_0012.h5 a time
/// and mesh_0000.h5 with what does not change: places, volumes, labels. A run that goes on, maybe on another number of
/// ranks with another order of points, writes a mesh of its own.
std::unique_ptr<FieldWriter> make_xdmf_writer(FieldSetup setup);

}  // namespace calor
