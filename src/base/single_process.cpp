#include "base/single_process.hpp"

#include <cstdlib>
#include <utility>

namespace calor {

SingleProcess::SingleProcess() {
  for (const char* launched : {"PMIX_RANK", "PMI_RANK"})
    if (std::getenv(launched)) return;
  for (const auto& [name, value] : {std::pair{"OMPI_MCA_ess_singleton_isolated", "1"},
                                    {"OMPI_MCA_orte_create_session_dirs", "0"},
                                    {"OMPI_MCA_pml", "ob1"},
                                    {"OMPI_MCA_btl", "self"},
                                    {"OMPI_MCA_coll", "basic,self,libnbc"},
                                    {"HWLOC_COMPONENTS", "-pci,-linuxio,-opencl"}})
    if (!std::getenv(name)) setenv(name, value, 1), added_.emplace_back(name);
}

SingleProcess::~SingleProcess() {
  for (const std::string& name : added_) unsetenv(name.c_str());
}

}  // namespace calor
