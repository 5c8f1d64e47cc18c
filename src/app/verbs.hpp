#pragma once
// The verbs of the command besides `run`; each returns the exit code.
#include <mpi.h>

#include <string>
#include <vector>

#include "case/case.hpp"

namespace calor {

/// Builds everything and says sizes, time-step bound and memory; runs nothing. Collective.
int check_case(const Case& c, MPI_Comm comm);

/// Runs the cases below the given files and folders, with all their variants, as far as they carry [[expect]] entries;
/// a line each, then 'N passed, M failed'. `json`: file for the list of results, or empty. Collective.
int verify(const std::vector<std::string>& paths, const std::string& json, MPI_Comm comm);

/// Writes NAME.toml, a copy of an example with the files that it names: of `from`, or of the starter of that name, or
/// of the plate. Never overwrites. Without a name it lists the starters. Throws Error.
int new_case(const std::string& name, const std::string& from);
/// Lists the cases that come with calor, a sentence each: all, or those with a word. Throws Error.
int list_examples(const std::string& word);

/// Becomes the Python package, which draws pictures and writes pages: words such as plot RESULT. It is found in the
/// share folder beside the command, or in the source tree of a build. Throws Error(command) where it or Python is
/// missing.
[[noreturn]] void become_python(const std::vector<std::string>& words);

/// Runs `ranks` copies of this command under mpiexec, without -j. SIGINT, SIGTERM and SIGHUP end the run after the
/// current step; a second one ends it at once, as does, after SIGTERM and SIGHUP, half a minute. When this process is
/// killed, mpiexec and the ranks end too. Returns the exit code; throws Error(command) where there is no mpiexec.
int launch(int ranks, const std::vector<std::string>& arguments);
/// Lets a rank started by launch() end together with its mpiexec, however that ends.
void end_with_launcher();

}  // namespace calor
