#include "tools/signals.h"

#include <pthread.h>
#include <signal.h>

#include <thread>

#include "scatmap/base/temporary_folder.h"

namespace scatmap::tools {
namespace {

// A signal handler may do next to nothing; a thread that waits for the signal may take folders away.
[[noreturn]] void wait_and_end(sigset_t awaited) {
  int number = 0;
  while (sigwait(&awaited, &number) != 0) {
  }
  abandon_temporary_folders();
  signal(number, SIG_DFL);
  sigset_t only{};
  sigemptyset(&only);
  sigaddset(&only, number);
  pthread_sigmask(SIG_UNBLOCK, &only, nullptr);
  for (;;) raise(number);
}

}  // namespace

void clean_up_on_signals() {
  sigset_t awaited{};
  sigemptyset(&awaited);
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction now {};
    if (sigaction(number, nullptr, &now) == 0 && now.sa_handler != SIG_IGN) sigaddset(&awaited, number);
  }
  pthread_sigmask(SIG_BLOCK, &awaited, nullptr);
  std::thread(wait_and_end, awaited).detach();
}

}  // namespace scatmap::tools
