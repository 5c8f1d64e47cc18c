#pragma once
// MPI and PETSc in a process of Python.

namespace calor::python {

/// Starts MPI and PETSc where nobody has done so yet; what is started here ends with Python. Throws Error.
void start_session();

/// Messages of the library go to standard error, errors and warnings alone: notes are attributes of what they are
/// about.
void quiet_log();

}  // namespace calor::python
