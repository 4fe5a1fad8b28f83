#pragma once

// Shared by the sources of this folder only.

namespace polhode::detail {

/// TDB - TT at the geocentre, s; the argument counts TT (or TDB, all the same) from J2000, s. That is eraDtdb, which
/// takes ten microseconds, by Chebyshev series over pieces of eight days that each thread makes when it first needs
/// them: within 1e-15 s over 1900 to 2100 (tests/unit/time_test.cpp), and the same bits whoever asks.
double tdb_minus_tt_s(double tt_s);

}  // namespace polhode::detail
