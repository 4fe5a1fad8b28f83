#pragma once

#include <string>

#include "polhode/ephemeris/ephemeris.hpp"
#include "polhode/write/stream.hpp"

namespace polhode {

/// A CCSDS Attitude Comprehensive Message (504.0-B-2) in KVN: quaternions, scalar last, from the ephemeris' frame to
/// SC_BODY_1 (or what the description says), passive, as in write_aem(); angular velocities in body axes, deg/s; the
/// tensor of inertia, if it is known in kg m2; and of an ephemeris with a covariance the variances, deg^2, of small
/// turns about the body's axes (an ACM holds no covariances between them). Numbers and times as in write_aem().
///
/// Throws InputError for a time scale that CCSDS has not, FileError, and what Ephemeris::fill and `progress` throw;
/// then there is no file.
void write_acm(const std::string& path, const Ephemeris& ephemeris, const Progress& progress = {});

}  // namespace polhode
