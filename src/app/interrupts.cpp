#include "app/interrupts.hpp"

#include <unistd.h>

#include <csignal>
#include <cstring>
#include <initializer_list>

#include "app/verbs.hpp"

namespace calor {
namespace {

volatile std::sig_atomic_t noted = 0, waits = 0, speaks = 0, base_of_codes = 128;
int (*ask)() = [] { return static_cast<int>(noted); };

void heed(int number) {
  const int meant = number == SIGUSR1 ? SIGINT : number;
  if (waits) {
    noted = meant;
    std::signal(number, SIG_DFL);  // the second time it is meant
    return;
  }
  constexpr const char* words = "calor: interrupted before there was a result: nothing has been stored\n";
  if (speaks) [[maybe_unused]]
    const ssize_t told = write(STDERR_FILENO, words, std::strlen(words));
  _exit(base_of_codes + meant);
}

}  // namespace

void catch_interrupts(int rank) {
  speaks = rank == 0;
  base_of_codes = code_for_launcher(128 + SIGINT) - SIGINT;
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGUSR1}) {
    const auto before = std::signal(number, heed);
    if (number == SIGHUP && before == SIG_IGN) std::signal(number, SIG_IGN);  // nohup
  }
}

InterruptsWait::InterruptsWait() { waits = 1; }
InterruptsWait::~InterruptsWait() { waits = 0; }

void ask_for_interrupts(int (*asked)()) { ask = asked; }

int interrupted_by() { return ask(); }

}  // namespace calor
