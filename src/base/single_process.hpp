#pragma once
#include <string>
#include <vector>

namespace calor {

/// While MPI starts: a process that nobody has launched needs neither Open MPI's helper process nor its folders for
/// several processes, over which runs that start at once trip, and no network. Looking for networks takes most of the
/// start: the libraries of some of them measure the processor's clock for 0.2 s. Neither devices nor what makes
/// messages among many fast are of use to it. What the environment says already stays; what is added ends with this, as
/// it is not meant for processes that are started from here.
class SingleProcess {
 public:
  SingleProcess();
  ~SingleProcess();
  SingleProcess(const SingleProcess&) = delete;
  SingleProcess& operator=(const SingleProcess&) = delete;

 private:
  std::vector<std::string> added_;
};

}  // namespace calor
