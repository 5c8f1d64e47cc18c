#pragma once
// Checkpoints: the state of a run in two files of its folder, written by turns, so that one is whole at any time.
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/archive.hpp"
#include "case/case.hpp"

namespace calor {

/// What a checkpoint is of. The first entries of its archive.
struct CheckpointHead {
  std::string version, case_json, written;  ///< written: date and time, UTC
  int ranks = 0;
  long steps = 0;
  double t = 0;  ///< s

  void exchange(Archive& archive);
};

/// A checkpoint that a run can go on from.
struct StoredRun {
  CheckpointHead head;
  std::unique_ptr<ArchiveReader> archive;  ///< after its head
  int slot = 0;
  std::vector<std::string> notes;  ///< what is to be said of a damaged one
};

/// The newest sound checkpoint of a folder. Throws Error(file) where there is none, Error(bad_case) where it is one of
/// another case, with the first key that differs. Collective.
StoredRun find_checkpoint(MPI_Comm comm, const std::string& folder, const Case& c);

class Checkpoints {
 public:
  /// `last`: the slot that the run goes on from. An empty folder keeps nothing.
  Checkpoints(const Case& c, const NumberedPoints& points, std::string folder, std::optional<int> last);

  bool are_kept() const { return !folder_.empty(); }
  /// Writes one over the older of the two. Throws Error(file) on all ranks; then the other one still stands.
  /// Collective.
  void write(double t, long steps, const std::function<void(Archive&)>& exchange);
  /// After a run that came to its end, and before a new one. Collective.
  void remove() const;

 private:
  const Case& case_;
  const NumberedPoints& points_;
  std::string folder_;
  int next_;
};

/// Where the next restart would begin, "at t = 3.2 s (step 1234)", by what the files say; nothing without any. For
/// rank 0 alone.
std::optional<std::string> newest_checkpoint(const std::string& folder);

}  // namespace calor
