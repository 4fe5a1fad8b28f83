#pragma once

#include <string>
#include <vector>

#include "polhode/motion/motion.hpp"

namespace polhode {

/// A case file: a free body at t = 0 and the times wanted, in seconds. Whitespace-separated text, `#` comments,
/// decimal or C99 hexadecimal numbers: `I I1 I2 I3`, `q q0 q1 q2 q3`, `m m1 m2 m3`, one `t T` per time.
struct CaseFile {
  FreeBody body;
  std::vector<double> times_s;
};

/// Throws InputError with file and line, FileError if the file cannot be read.
CaseFile read_case_file(const std::string& path);

}  // namespace polhode
