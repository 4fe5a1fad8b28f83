// A libFuzzer target for each reader, chosen by the environment's POLHODE_FUZZ: any input is read or refused with
// InputError, nothing else.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "polhode/base/error.hpp"
#include "polhode/body/mesh_inertia.hpp"
#include "polhode/read/asteroid_files.hpp"
#include "polhode/read/body_file.hpp"
#include "polhode/read/ccsds_attitude.hpp"
#include "polhode/read/mesh_file.hpp"

namespace {

void read_ccsds(const std::string& text) {
  using namespace polhode;
  for (const CcsdsAttitudeMessage& message : parse_ccsds_attitude(text, "fuzz")) {
    if (!message.history) continue;
    for (const AttitudeSegment& s : message.history->segments) {
      const Seconds half{0.5 * (s.samples.back().time - s.samples.front().time).high, 0.0};
      interpolate(s, s.samples.front().time + half);
    }
  }
}

void read_asteroid(const std::string& text) {
  using namespace polhode;
  if (is_damit_table(text)) {
    parse_damit_table(text, "fuzz", "");
  } else if (is_damit_spin(text)) {
    parse_damit_spin(text, "fuzz");
  } else {
    parse_shape_model(text, "fuzz");
  }
}

using Reader = void (*)(const std::string&);

Reader chosen_reader() {
  const char* name = std::getenv("POLHODE_FUZZ");
  const std::string reader = name == nullptr ? "" : name;
  if (reader == "ccsds") return read_ccsds;
  if (reader == "asteroid") return read_asteroid;
  if (reader == "mesh")
    return [](const std::string& text) { polhode::mass_properties(polhode::read_mesh(text, "fuzz")); };
  if (reader == "body") return [](const std::string& text) { polhode::parse_body_file(text, "fuzz"); };
  std::fputs("POLHODE_FUZZ must be ccsds, asteroid, mesh or body\n", stderr);
  std::exit(2);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Reader read = chosen_reader();
  try {
    read(std::string(reinterpret_cast<const char*>(data), size));
  } catch (const polhode::InputError&) {
  } catch (const polhode::FileError&) {  // a body file may name a mesh that is not there
  }
  return 0;
}
