#pragma once
// A new HDF5 file that all ranks write together through MPI-IO: arrays with a row a point or facet, rank after rank,
// compressed.
#include <hdf5.h>
#include <mpi.h>

#include <cstdint>
#include <span>
#include <string>

namespace calor {

/// All functions are collective and throw Error(file) on all ranks.
class Hdf5File {
 public:
  /// `most_bytes` are asked of the disk before anything is written.
  Hdf5File(MPI_Comm comm, std::string path, std::int64_t most_bytes);
  ~Hdf5File();
  Hdf5File(const Hdf5File&) = delete;
  Hdf5File& operator=(const Hdf5File&) = delete;

  void make_group(const std::string& name);
  /// An array of this rank's rows after those of the lower ranks; row-major. `unit` becomes its attribute, if any.
  void write(const std::string& name, int components, std::span<const double> mine, const std::string& unit = "");
  void write(const std::string& name, int components, std::span<const std::int64_t> mine);
  /// Ends the file; what could not be written until then is an error.
  void close();

 private:
  void write(const std::string& name, int components, std::size_t entries, const void* mine, hid_t type,
             const std::string& unit);
  /// Throws where the work has failed on any rank.
  void require(bool good);

  MPI_Comm comm_;
  std::string path_;
  hid_t file_ = -1;
};

}  // namespace calor
