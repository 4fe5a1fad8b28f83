#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "polhode/motion/motion.hpp"
#include "polhode/torque/torques.hpp"

namespace polhode {

/// A case file: a body at t = 0, the torques on it and the times wanted, in seconds. Whitespace-separated text, `#`
/// comments, decimal or C99 hexadecimal numbers: `I I1 I2 I3`, `q q0 q1 q2 q3`, `m m1 m2 m3`, one `t T` per time, and a
/// line per torque:
///
///     T gravity-gradient MU Q E TP  P1 P2 P3  W1 W2 W3    point mass (m3/s2); periapsis m, eccentricity, its time s,
///                                                         direction of periapsis, orbit normal, inertial
///     T constant-body a b c                               in body axes, unit of m / s
///     T linear-body d1 d2 d3                              torque_i = -d_i omega_i, unit of I / s
struct CaseFile {
  FreeBody body;
  Torques torques;
  std::vector<double> times_s;
};

/// Throws InputError with file and line, FileError if the file cannot be read.
CaseFile read_case_file(const std::string& path);

/// The same from memory; `path` is for messages.
CaseFile parse_case_file(std::string_view text, const std::string& path);

}  // namespace polhode
