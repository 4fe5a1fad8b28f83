#pragma once

#include <string>

namespace polhode::tools {

/// For the start of the program:
/// - a signal that ends it removes the hidden files of unfinished outputs first; signals that whoever started the
///   program has had ignored stay ignored;
/// - a write to a pipe that nobody reads, or beyond the limit of a file's size, is an error like any other;
/// - no file that is opened later takes the place of a standard stream that was closed.
void prepare_for_signals_and_closed_streams();

/// Ends the program as a write to a pipe that nobody reads usually does, unless that is ignored.
void end_by_broken_pipe();

/// What a signal writes to standard error, while this object lives, if there was a hidden file to remove.
class StoppedNote {
 public:
  explicit StoppedNote(std::string text);
  StoppedNote(const StoppedNote&) = delete;
  StoppedNote& operator=(const StoppedNote&) = delete;
  ~StoppedNote();

 private:
  std::string text_;
};

}  // namespace polhode::tools
