#pragma once

#include "polhode/base/error.hpp"

namespace polhode {

/// Runs `work`, and gives an InputError of its own that knows no place this one.
template <class Work>
auto located(const SourceLocation& where, const Work& work) {
  try {
    return work();
  } catch (const InputError& problem) {
    if (!problem.where().file.empty()) throw;
    throw InputError(where, problem.what());
  }
}

}  // namespace polhode
