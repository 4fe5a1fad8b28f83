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

bool is_ignored(const struct sigaction& action) {
  return (action.sa_flags & SA_SIGINFO) == 0 && action.sa_handler == SIG_IGN;
}

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

// Libraries may put handlers of their own in place before main(), even for signals that were ignored: UCX does, which
// SUNDIALS brings along by way of MPI. They print and end the program, and hidden files stay. So what was ignored is
// noted before any library is initialised, and their handlers give way; but a sanitizer's say what is wrong.
std::array<bool, 65> ignored_at_first{};

#ifdef __SANITIZE_ADDRESS__
constexpr bool kSanitizersHandle = true;
#else
constexpr bool kSanitizersHandle = false;

void note_ignored_signals() {
  for (int signal = 1; signal < static_cast<int>(ignored_at_first.size()); ++signal) {
    struct sigaction now {};
    ignored_at_first[static_cast<std::size_t>(signal)] = sigaction(signal, nullptr, &now) == 0 && is_ignored(now);
  }
}

[[gnu::section(".preinit_array"), gnu::used]] void (*const note_ignored_signals_first)() = note_ignored_signals;
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
    if (ignored_at_first[static_cast<std::size_t>(signal)]) std::signal(signal, SIG_IGN);
    const bool is_usual = (now.sa_flags & SA_SIGINFO) == 0 && now.sa_handler == SIG_DFL;
    if (ignored_at_first[static_cast<std::size_t>(signal)] || is_ignored(now)) continue;
    if (!is_usual && kSanitizersHandle) continue;
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
