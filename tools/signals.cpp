#include "signals.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <string_view>
#include <utility>

#include "polhode/write/output_file.hpp"

namespace polhode::tools {
namespace {

std::atomic<const std::string*> stopped_note{nullptr};

void end_by(int signal) {
  struct sigaction usual {};
  usual.sa_handler = SIG_DFL;
  sigaction(signal, &usual, nullptr);
  std::raise(signal);
}

/// Whatever the program does just then, on whichever thread: nothing here but calls that are async-signal-safe.
void clean_up_and_end(int signal, siginfo_t* info, void* /*context*/) {
  if (signal == SIGPIPE && info->si_pid == ::getpid()) return;  // our own write: it returns EPIPE
  const std::string* note = stopped_note.load();
  if (remove_hidden_files() && note != nullptr) {
    [[maybe_unused]] const ssize_t ignored = ::write(STDERR_FILENO, note->data(), note->size());
  }
  end_by(signal);
}

// Handlers that are there when the program begins are those of libraries, which print and end it (UCX's, which SUNDIALS
// brings along by way of MPI), and leave hidden files; but a sanitizer's say what is wrong.
#ifdef __SANITIZE_ADDRESS__
constexpr bool kSanitizersHandle = true;
#else
constexpr bool kSanitizersHandle = false;
#endif

/// What ends a program by default, but for SIGKILL.
bool ends_programs(int signal) {
  constexpr std::array others{SIGKILL, SIGSTOP, SIGCHLD, SIGCONT, SIGTSTP, SIGTTIN, SIGTTOU, SIGURG, SIGWINCH, SIGXFSZ};
  return std::find(others.begin(), others.end(), signal) == others.end();
}

}  // namespace

void prepare_for_signals_and_closed_streams() {
  for (const auto& [stream, mode] :
       {std::pair{STDIN_FILENO, O_WRONLY}, std::pair{STDOUT_FILENO, O_RDONLY}, std::pair{STDERR_FILENO, O_WRONLY}}) {
    // Reading the one and writing the other stays an error.
    if (::fcntl(stream, F_GETFD) < 0) ::open("/dev/null", mode);
  }
  // A handler needs a stack where the usual one has overflowed.
  static std::array<char, 1 << 16> handlers_stack;
  const stack_t stack{handlers_stack.data(), 0, handlers_stack.size()};
  sigaltstack(&stack, nullptr);
  std::signal(SIGXFSZ, SIG_IGN);
  for (int signal = 1; signal <= SIGRTMAX; ++signal) {
    struct sigaction now {};
    if (!ends_programs(signal) || sigaction(signal, nullptr, &now) != 0) continue;
    const bool is_ignored = (now.sa_flags & SA_SIGINFO) == 0 && now.sa_handler == SIG_IGN;
    const bool is_usual = (now.sa_flags & SA_SIGINFO) == 0 && now.sa_handler == SIG_DFL;
    if (is_ignored || (!is_usual && kSanitizersHandle)) continue;
    struct sigaction wanted {};
    wanted.sa_sigaction = clean_up_and_end;
    wanted.sa_flags = SA_SIGINFO | SA_ONSTACK | SA_NODEFER;
    sigaction(signal, &wanted, nullptr);
  }
}

void end_by_broken_pipe() {
  struct sigaction now {};
  sigaction(SIGPIPE, nullptr, &now);
  if ((now.sa_flags & SA_SIGINFO) != 0) end_by(SIGPIPE);
}

StoppedNote::StoppedNote(std::string text) : text_(std::move(text)) { stopped_note = &text_; }

StoppedNote::~StoppedNote() { stopped_note = nullptr; }

}  // namespace polhode::tools
