#pragma once
// Signals that ask a run to end.

namespace calor {

/// Lets SIGINT, SIGTERM and SIGHUP, and SIGUSR1 (which mpiexec and batch systems pass on, and which counts as SIGINT),
/// end the process at once with 128 + its number, and the process of rank 0 say so; but while InterruptsWait lives
/// they are noted. The second time they end the process in any case.
void catch_interrupts(int rank);

/// While it lives there are results to be put in order before the process ends.
class InterruptsWait {
 public:
  InterruptsWait();
  ~InterruptsWait();
  InterruptsWait(const InterruptsWait&) = delete;
  InterruptsWait& operator=(const InterruptsWait&) = delete;
};

/// Number of the signal that has been noted, or 0.
int interrupted_by();

}  // namespace calor
