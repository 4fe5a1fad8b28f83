#pragma once

#include "polhode/base/error.hpp"

namespace polhode {

/// Runs `work`, and gives an InputError of its own, which knows no place, this one.
template <class Work>
auto located(const SourceLocation& where, const Work& work) {
  try {
    return work();
  } catch (const InputError& problem) {
    throw InputError(where, problem.what());
  }
}

}  // namespace polhode
