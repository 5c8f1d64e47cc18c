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

/// For a program that handles signals itself: `asked` tells the number of the one that asks the run to end, or 0.
void ask_for_interrupts(int (*asked)());

/// Number of the signal that asks the run to end, or 0.
int interrupted_by();

}  // namespace calor
