#pragma once
// The verbs of the command besides `run`; each returns the exit code.
#include <mpi.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "case/case.hpp"

namespace calor {

/// Builds everything and says sizes, time-step bound and memory, or lists the numbers that the report of a run has;
/// runs nothing. Collective.
int check_case(const Case& c, MPI_Comm comm, bool lists_numbers);

/// Makes the cloud alone, writes it as NAME.vtu and NAME-surface.vtp, and tells how good it is. Collective.
int show_cloud(const Case& c, const std::string& name, MPI_Comm comm);

/// Prints the case as a file of its own, as a run sees it; with its variants where none was chosen.
int show_case(const Case& c);
/// Prints how a unit converts: what a difference of 1 is, and what 0 is. Throws Error(command).
int show_unit(const std::string& unit, const std::string& other);

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

constexpr int machine_lacks = 6;  ///< exit code where MPI cannot start or memory is short
constexpr int out_of_time = 75;   ///< exit code of a run that its limit of time ended: EX_TEMPFAIL of sysexits.h

/// What the machine does not have; ends the command with the code machine_lacks.
class MachineLacks : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Launched {
  int code;      ///< of the command
  bool is_told;  ///< the ranks have said why
};
/// Runs `ranks` copies of this command under mpiexec, without -j. SIGINT, SIGTERM and SIGHUP go to the ranks; a second
/// one ends them at once, as does, after SIGTERM and SIGHUP, half a minute. When this process is killed, mpiexec and
/// the ranks end too. Throws MachineLacks where mpiexec does not start them.
Launched launch(int ranks, const std::vector<std::string>& arguments);
/// The code by which a rank started by launch() tells its exit code; the code itself elsewhere.
int code_for_launcher(int code);
/// Lets a rank started by launch() end together with its mpiexec, however that ends.
void end_with_launcher();

}  // namespace calor
