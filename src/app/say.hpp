#pragma once
// Words on the terminal, which may be closed or a full disk. Nothing here throws.
#include <string>

namespace calor {

/// Opens /dev/null in the place of standard files that are closed, so that no file of a result takes their place.
void open_standard_files();

/// Writes to standard output; whether it got there `finish_output` tells.
void say(const std::string& text);
/// Writes a line to standard error.
void complain(const std::string& line);

/// At the end: the exit code `code`, or Fault::file with a line where standard output could not be written. After it
/// standard output takes anything.
int finish_output(int code);

}  // namespace calor
