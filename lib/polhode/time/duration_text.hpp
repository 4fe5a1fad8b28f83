#pragma once

#include <string>

namespace polhode {

/// A length of time for people, rounded to three digits, in the unit that suits it: "13.2 s", "4.72 h", "35 d",
/// "2.61 years" (of 365.25 d).
std::string duration_text(double seconds);

}  // namespace polhode
