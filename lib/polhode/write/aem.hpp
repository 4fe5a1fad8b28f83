#pragma once

#include <span>
#include <string>
#include <string_view>

#include "polhode/body/euler.hpp"
#include "polhode/ephemeris/ephemeris.hpp"
#include "polhode/write/stream.hpp"

namespace polhode {

/// What a row of an AEM holds after its time. Quaternions have their scalar last; angles are degrees, rates degrees per
/// second, quaternion derivatives 1/s. Euler angles take A to B.
enum class AemType {
  quaternion,                   ///< QUATERNION
  quaternion_derivative,        ///< QUATERNION/DERIVATIVE
  quaternion_angular_velocity,  ///< QUATERNION/ANGVEL, components in frame B; ADM 2.0 only
  euler_angle,                  ///< EULER_ANGLE
  euler_angle_derivative,       ///< EULER_ANGLE/DERIVATIVE; ADM 2.0 only
  euler_angle_angular_velocity  ///< EULER_ANGLE/ANGVEL, components in frame B; ADM 2.0 only
};

/// By the standard's name, any case. Throws InputError naming the allowed ones.
AemType aem_type(std::string_view name);

enum class AdmVersion {
  v1,  ///< CCSDS 504.0-B-1 (2008), which GMAT and STK read
  v2,  ///< CCSDS 504.0-B-2 (2024)
};

/// "1.0" or "2.0". Throws InputError.
AdmVersion adm_version(std::string_view name);

struct AemOptions {
  AdmVersion version = AdmVersion::v2;
  bool xml = false;
  AemType type = AemType::quaternion_angular_velocity;
  EulerSequence euler_sequence{"ZXZ"};  ///< of the types with Euler angles
};

/// A CCSDS Attitude Ephemeris Message, one segment per ephemeris; all have one object. Frame A is the ephemeris' frame,
/// frame B (SC_BODY_1, or what the description says) the axes that the body's file names; the quaternion takes
/// components from A to B, passive: our q_frame_from_named with its scalar moved to the end and no sign changed. A body
/// turned by +90 degrees about inertial z has Q1 Q2 Q3 QC = 0 0 0.7071 0.7071. Every number is the shortest text that
/// reads back as the same double, and every row is computed at exactly the time that its text says.
///
/// Throws InputError for a type or a time scale that the version has not, and for two segments that share more than an
/// instant, FileError, and what Ephemeris::fill and `progress` (which counts over all segments) throw; then there is no
/// file.
void write_aem(const std::string& path, std::span<const Ephemeris> segments, const AemOptions& options = {},
               const Progress& progress = {});

}  // namespace polhode
