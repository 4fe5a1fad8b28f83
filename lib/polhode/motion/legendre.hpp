#pragma once

#include <memory>

#include "polhode/motion/motion.hpp"

namespace polhode {

/// The classical closed form as Leroy (2020), "On an Article by Celledoni et al.", gives it: Jacobi functions for the
/// momentum, Legendre's third integral for the precession angle, in the cases (i), (ii), (iii); and constant momentum.
/// How its formulas are kept free of cancellation: motion/legendre.md. Measured on the reference corpus: see the
/// figures in tests/golden/truth_corpus_test.cpp. Shares no formula with the theta solution, whose second opinion it
/// is.
std::unique_ptr<Motion> make_legendre(const FreeBody& body);

}  // namespace polhode
