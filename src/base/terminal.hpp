#pragma once
// Who reads what the command says?

namespace calor {

/// Does stderr end up on a terminal? Ranks under mpiexec, which write to a pipe, are told so by CALOR_TERMINAL.
bool stderr_is_terminal();
/// May stdout be coloured? On a terminal, unless NO_COLOR (https://no-color.org) is set; ranks are told by
/// CALOR_COLOUR.
bool stdout_takes_colour();

}  // namespace calor
