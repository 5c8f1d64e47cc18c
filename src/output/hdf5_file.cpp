#include "output/hdf5_file.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

#include "base/parallel.hpp"
#include "output/files.hpp"

namespace calor {
namespace {

/// What HDF5 gives a number to, closed when it is no longer needed.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }
  bool is_good() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

bool add_text(hid_t object, const char* name, const std::string& text) {
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose), space(H5Screate(H5S_SCALAR), H5Sclose);
  if (H5Tset_size(type, text.size()) < 0) return false;
  const Handle attribute(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  return attribute.is_good() && H5Awrite(attribute, type, text.data()) >= 0;
}

/// Throws Error(file) where a file of that size has no room.
void require_room(const std::string& path, std::int64_t bytes) {
  std::error_code unknown;
  const auto space = std::filesystem::space(std::filesystem::path(path).parent_path(), unknown);
  if (!unknown && space.available < static_cast<std::uintmax_t>(bytes)) refuse_writing(path, ENOSPC);
  rlimit limit{};
  if (getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur < static_cast<rlim_t>(bytes)) refuse_writing(path, EFBIG);
}

}  // namespace

Hdf5File::Hdf5File(MPI_Comm comm, std::string path, std::int64_t most_bytes) : comm_(comm), path_(std::move(path)) {
  // MPI-IO waits for ever where a disk becomes full.
  collective_try(comm, [&] {
    if (rank_of(comm) == 0) require_room(path_, most_bytes);
  });
  H5dont_atexit();                              // it would close files that could not be written
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // errors are told by Error
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  if (size_of(comm) > 1) H5Pset_fapl_mpio(access, comm, MPI_INFO_NULL);
  errno = 0;
  file_ = H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
  require(file_ >= 0);
}

Hdf5File::~Hdf5File() {
  if (file_ >= 0) H5Fclose(file_);
}

void Hdf5File::require(bool good) {
  const int error = size_of(comm_) > 1 ? 0 : errno;  // MPI leaves anything there
  if (!any(comm_, !good)) return;
  file_ = -1;  // left as it is: what could not be written once crashes HDF5 when it is closed
  collective_try(comm_, [&] { refuse_writing(path_, error ? error : EIO); });
}

void Hdf5File::make_group(const std::string& name) {
  require(Handle(H5Gcreate2(file_, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose).is_good());
}

void Hdf5File::write(const std::string& name, int components, std::span<const double> mine, const std::string& unit) {
  write(name, components, mine.size(), mine.data(), H5T_NATIVE_DOUBLE, unit);
}

void Hdf5File::write(const std::string& name, int components, std::span<const std::int64_t> mine) {
  write(name, components, mine.size(), mine.data(), H5T_NATIVE_INT64, "");
}

void Hdf5File::write(const std::string& name, int components, std::size_t entries, const void* mine, hid_t type,
                     const std::string& unit) {
  constexpr hsize_t rows_of_chunk = 1 << 15;
  constexpr int fast = 1;  // the next levels take twice the time for a twentieth of the size
  const int rank = components > 1 ? 2 : 1;
  const hsize_t width = components, rows = entries / width;
  const hsize_t all = total(comm_, static_cast<std::int64_t>(rows)),
                before = offset(comm_, static_cast<std::int64_t>(rows));
  const std::array<hsize_t, 2> shape{all, width}, here{rows, width}, begin{before, 0},
      chunk{std::clamp<hsize_t>(all, 1, rows_of_chunk), width};
  const Handle space(H5Screate_simple(rank, shape.data(), nullptr), H5Sclose),
      memory(H5Screate_simple(rank, here.data(), nullptr), H5Sclose), layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose),
      transfer(H5Pcreate(H5P_DATASET_XFER), H5Pclose);
  H5Pset_chunk(layout, rank, chunk.data()), H5Pset_shuffle(layout), H5Pset_deflate(layout, fast);
  if (size_of(comm_) > 1) H5Pset_dxpl_mpio(transfer, H5FD_MPIO_COLLECTIVE);
  if (rows > 0)
    H5Sselect_hyperslab(space, H5S_SELECT_SET, begin.data(), nullptr, here.data(), nullptr);
  else
    H5Sselect_none(space), H5Sselect_none(memory);
  errno = 0;
  const hid_t dataset = H5Dcreate2(file_, name.c_str(), type, space, H5P_DEFAULT, layout, H5P_DEFAULT);
  require(dataset >= 0 && (unit.empty() || add_text(dataset, "unit", unit)));
  const bool is_written = H5Dwrite(dataset, type, memory, space, transfer, mine) >= 0;
  require(is_written && H5Dclose(dataset) >= 0);
}

void Hdf5File::close() {
  errno = 0;
  require(H5Fclose(std::exchange(file_, -1)) >= 0);
}

}  // namespace calor
