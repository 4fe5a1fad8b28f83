#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polhode/body/body.hpp"
#include "polhode/ephemeris/attitude_history.hpp"
#include "polhode/read/input_formats.hpp"

namespace polhode {

/// One attitude message: APM 1.0 or 2.0, AEM 1.0 or 2.0, ACM 2.0.
struct CcsdsAttitudeMessage {
  std::string kind;                        ///< "APM", "AEM", "ACM"
  std::string version;                     ///< "1.0", "2.0"
  Body body;                               ///< its inertia and state; `body.missing` says what a propagation would need
  std::optional<AttitudeHistory> history;  ///< of an AEM, and of the attitude blocks of an ACM
};

/// The attitude messages of a file in KVN or XML, alone or in a combined NDM, held against CCSDS 504.0-B-1
/// (version 1.0) and 504.0-B-2 (version 2.0), in all blocks:
/// - directions and element orders as each version says: quaternions and Euler angles lead from frame A to frame B, and
///   B's axes are A's axes turned by them (504.0-B-2 annex F); version 1 may say B2A, and FIRST;
/// - Euler angles are intrinsic, in the order of EULER_ROT_SEQ; *_RATE of version 1 are their derivatives, as its own
///   examples and Orekit have them;
/// - spin data are the model of annex F5: the attitude is Z-X-Z by (alpha + 90, 90 - delta, spin angle), the rate is
///   SPIN_ANGLE_VEL about the spin axis and the nutation's rate about the angular momentum;
/// - IXY, IXZ, IYZ are integrals of xy dm, so that the tensor holds -IXY (annex F6); I12, I13, I23 of version 1 the
/// same.
///
/// Throws InputError with file and line for what the standard forbids: unknown, repeated or missing keywords, values
/// and units that are not allowed, blocks out of order, times that do not increase, and so on. Reads with a warning
/// what real files do against it without doubt in the meaning. What is not needed is checked and left out with a note.
std::vector<CcsdsAttitudeMessage> parse_ccsds_attitude(std::string_view text, const std::string& name);

/// Of several messages the body of the one that lacks least, the first of them, and the first attitude history.
BodyAndHistory read_ccsds_attitude(const std::string& text, const RowOfFile& place, const ContentOf& content_of);

}  // namespace polhode
