#pragma once

#include <string>

#include "polhode/base/error.hpp"

namespace polhode::tools {

/// Runs `work`, and puts the file's name before an InputError of its own.
template <class Work>
auto in_file(const std::string& file, const Work& work) {
  try {
    return work();
  } catch (const InputError& error) {
    throw InputError({file, 0}, error.what());
  }
}

/// The same with an option's name.
template <class Work>
auto in_option(const std::string& option, const Work& work) {
  return in_file(option, work);
}

}  // namespace polhode::tools
