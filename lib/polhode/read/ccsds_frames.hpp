#pragma once

#include <optional>
#include <string_view>

#include "polhode/frames/frame.hpp"

namespace polhode {

/// Whether a name is one of the spacecraft's own frames: SC_BODY_1, STARTRACKER_2, … (the SANA registry of spacecraft
/// body reference frames, and the names of 504.0-B-1 annex A3), with at most one further label.
bool is_local_frame(std::string_view name);

/// The inertial frame that a message calls so; nothing for one that is not inertial, or not known.
std::optional<Frame> known_inertial_frame(std::string_view name);

/// Whether CCSDS registers the name, also of frames that turn or follow an orbit.
bool is_registered_frame(std::string_view name);

/// Whether two names mean one frame. SC_BODY without a number is SC_BODY_1.
bool same_frame(std::string_view a, std::string_view b);

}  // namespace polhode
