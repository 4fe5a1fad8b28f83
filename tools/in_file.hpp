#pragma once

#include <string>

#include "polhode/base/error.hpp"
#include "polhode/base/located.hpp"

namespace polhode::tools {

/// The command line asks for what it may not. The message names the option; no file is at fault.
class OptionError : public InputError {
 public:
  using InputError::InputError;
};

/// Runs `work`, and puts the file's name before a ComputationError, and before an InputError that names neither a place
/// nor an option. Each command does its work within the file that it reads: what the library finds wrong, and where it
/// does not know the file, is said of that file.
template <class Work>
auto in_file(const std::string& file, const Work& work) {
  try {
    return work();
  } catch (const OptionError&) {
    throw;
  } catch (const InputError& error) {
    if (!error.where().file.empty()) throw;
    throw InputError({file, 0}, error.what());
  } catch (const ComputationError& error) {
    throw ComputationError(file + ": " + error.what());
  }
}

/// The same with an option's name.
template <class Work>
auto in_option(const std::string& option, const Work& work) {
  return located({option, 0}, work);
}

}  // namespace polhode::tools
