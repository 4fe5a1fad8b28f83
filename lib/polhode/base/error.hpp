#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

namespace polhode {

/// Where in the user's input a fault stands. `line` counts from 1; 0 means that no line applies.
struct SourceLocation {
  std::string file;
  std::size_t line = 0;

  /// `file:line`, or `file` alone.
  std::string text() const {
    std::string result = file;
    if (line != 0) result.append(1, ':').append(std::to_string(line));
    return result;
  }
};

/// The user's input breaks a rule (the program's exit status 2). The message states what was found and what is
/// allowed; what() puts `file:line: ` before it where they are known.
class InputError : public std::runtime_error {
 public:
  explicit InputError(const std::string& message) : std::runtime_error(message), message_(message) {}
  InputError(const SourceLocation& where, const std::string& message)
      : std::runtime_error(where.text() + ": " + message), where_(where), message_(message) {}

  /// Where it is known; else no file and line 0.
  const SourceLocation& where() const { return where_; }
  /// what() without the place.
  const std::string& message() const { return message_; }

 private:
  SourceLocation where_;
  std::string message_;
};

/// The rows of a file are asked for in a time scale that its format does not have.
class TimeScaleError : public InputError {
 public:
  using InputError::InputError;
};

/// A file cannot be read or written (the program's exit status 3).
class FileError : public std::runtime_error {
 public:
  explicit FileError(const std::string& message) : std::runtime_error(message) {}
};

/// A computation gave no usable answer for input that breaks no rule (the program's exit status 1).
class ComputationError : public std::runtime_error {
 public:
  explicit ComputationError(const std::string& message) : std::runtime_error(message) {}
};

}  // namespace polhode
