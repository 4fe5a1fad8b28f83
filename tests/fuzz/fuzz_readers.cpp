// A libFuzzer target for each reader, chosen by the environment's POLHODE_FUZZ: any input is read or refused with
// InputError, nothing else. Nothing is read from disk: files that the input names have a fixed content.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/ephemeris/resample.hpp"
#include "polhode/read/body.hpp"
#include "polhode/read/case_file.hpp"
#include "polhode/read/leap_seconds_file.hpp"
#include "polhode/read/scene_file.hpp"
#include "polhode/read/time_list.hpp"

namespace {

using namespace polhode;

/// What a body or scene file names: a mesh, or a body with every number that a torque may want.
std::string content_of(const std::string& path) {
  if (!path.ends_with(".toml")) return "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  return "name = 'body'\n[inertia]\nmoments = [3, 4, 5]\nunit = 'kg m2'\n[state]\nepoch = '2000-01-01 TT'\nframe = "
         "'ICRF'\n"
         "[state.attitude]\nq_frame_from_body_scalar_first = [1, 0, 0, 0]\n[state.angular_velocity]\n"
         "components = [0.1, 0.2, 0.3]\naxes = 'body'\nunit = 'rad/s'\n";
}

/// Reads and interpolates: once per segment from its first to its last instant.
void use(const std::optional<AttitudeHistory>& history) {
  if (!history) return;
  WantedTimes wanted;
  wanted.count = 3;
  for (Ephemeris& e : resample(*history, wanted, history->scale, std::nullopt)) {
    AttitudeBlock block;
    e.fill(0, e.times().size(), {TimeResolution::Kind::two_doubles}, block);
  }
}

using Reader = std::function<void(const std::string&)>;

const std::map<std::string_view, Reader> readers{
    {"case", [](const std::string& text) { parse_case_file(text, "fuzz"); }},
    {"scene", [](const std::string& text) { parse_scene(text, "fuzz", content_of); }},
    {"leap_seconds", [](const std::string& text) { set_leap_seconds(parse_leap_seconds(text, "fuzz")); }},
    {"times", [](const std::string& text) { parse_time_lines(text, TimeScale::utc, "fuzz"); }},
    // Any of them, as `polhode info` finds it out.
    {"any", [](const std::string& text) { read_body("fuzz", [&text](const std::string&) { return text; }); }},
};

/// Reads the text as one of the formats with samples in this folder: the first that recognises it, else the last.
Reader reader_of(std::string_view folder) {
  std::vector<InputFormat> formats;
  for (const InputFormat& format : input_formats()) {
    if (format.samples == folder) formats.push_back(format);
  }
  if (formats.empty()) return {};
  return [formats](const std::string& text) {
    static const RowOfFile place("fuzz");
    const auto found =
        std::find_if(formats.begin(), formats.end(), [&](const InputFormat& f) { return f.recognises(text); });
    use((found == formats.end() ? formats.back() : *found).read(text, place, content_of).history);
  };
}

Reader chosen_reader() {
  const char* variable = std::getenv("POLHODE_FUZZ");
  const std::string name = variable == nullptr ? "" : variable;
  const auto found = readers.find(name);
  if (found != readers.end()) return found->second;
  if (Reader reader = reader_of(name)) return reader;
  std::fputs("POLHODE_FUZZ must be a folder of data/ with samples of a format, or one of:", stderr);
  for (const auto& [known, reader] : readers) std::fprintf(stderr, " %s", std::string(known).c_str());
  std::fputs("\n", stderr);
  std::exit(2);
}

}  // namespace

// Less freed memory is kept out of use than by default: 256 MB of it would leave no meaning to a limit of memory.
extern "C" const char* __asan_default_options() { return "quarantine_size_mb=8"; }

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Reader read = chosen_reader();
  try {
    read(std::string(reinterpret_cast<const char*>(data), size));
  } catch (const polhode::InputError&) {
  } catch (const polhode::ComputationError&) {  // attitudes that overflow
  }
  return 0;
}
