#include <fmt/format.h>
#include <nanobind/operators.h>

#include "polhode/frames/frame.hpp"
#include "polhode/read/leap_seconds_file.hpp"
#include "polhode/time/leap_seconds.hpp"
#include "polhode/time/scale.hpp"
#include "python/python.hpp"

namespace polhode::python {
namespace {

std::pair<double, double> pair_of(Seconds s) { return {s.high, s.low}; }

Instant instant_from_text(const std::string& text, const std::optional<std::string>& scale) {
  return scale ? parse_date(text, time_scale(*scale)) : parse_date_with_scale(text).instant;
}

nb::object astropy_time(const Instant& instant) {
  constexpr double j2000 = 2451545.0, day_s = 86400.0;
  const Seconds tt = instant.tt_since_j2000();
  const double days = std::floor(tt.high / day_s);
  const Seconds rest = tt - exact_product(days, day_s);
  return nb::module_::import_("astropy.time")
      .attr("Time")(j2000 + days, (rest.high + rest.low) / day_s, "format"_a = "jd", "scale"_a = "tt");
}

FloatArray frame_rotation(const std::string& from, const std::string& to, const nb::object& at, double ut1_minus_utc_s,
                          double pole_x_arcsec, double pole_y_arcsec) {
  const Frame a = frame(from), b = frame(to);
  if (at.is_none()) return array_of(q_icrf_from(b).conjugate() * q_icrf_from(a));
  const EarthOrientation earth{ut1_minus_utc_s, pole_x_arcsec, pole_y_arcsec};
  const auto rotation = [&](const Instant& t) {
    return scalar_first(q_icrf_from(b, t, earth).conjugate() * q_icrf_from(a, t, earth)).eval();
  };
  const bool scalar = nb::isinstance<Instant>(at) || nb::isinstance<nb::str>(at) ||
                      (nb::hasattr(at, "isscalar") && nb::cast<bool>(at.attr("isscalar")));
  if (scalar) return array_of(Shape{4}, rotation(*instant_of(at)).data());
  const std::vector<Instant> instants = instants_of(at);
  auto [array, data] = new_array(Shape{instants.size(), 4});
  for (std::size_t i = 0; i < instants.size(); ++i) {
    Eigen::Map<Eigen::Vector4d>(data + 4 * i) = rotation(instants[i]);
  }
  return {std::move(array)};
}

}  // namespace

void bind_time(nb::module_& m) {
  nb::class_<Instant>(
      m, "Instant",
      "One instant, whatever the time scale: good to far less than a nanosecond. Instants compare, their "
      "difference is in SI seconds as TT counts them, and so is what is added to one.")
      .def(
          "__init__",
          [](Instant* self, const std::string& text, const std::optional<std::string>& scale) {
            new (self) Instant(instant_from_text(text, scale));
          },
          "date"_a, "scale"_a = nb::none(),
          "From a date: '2029-04-13T21:46:00 UTC', '2029-103T21:46 TDB', 'JD 2462240.407 TT', 'MJD 62239.9 TAI'. The "
          "scale (TT, TAI, UTC, TDB, GPS, ET) may be given apart. Raises InputError.")
      .def_static(
          "from_tt_j2000",
          [](double seconds, double rest) {
            return Instant::from_tt_j2000({seconds, rest});
          },
          "seconds"_a, "rest"_a = 0.0, "From TT seconds since 2000-01-01T12:00:00 TT, in two parts that add up.")
      .def_static(
          "of", [](const Given<When>& when) { return when->instant; }, "when"_a,
          "Of an astropy Time, a date or an Instant.")
      .def(
          "text",
          [](const Instant& self, const std::string& scale, int decimals) {
            return format_date(self, time_scale(scale), decimals);
          },
          "scale"_a = "TDB", "decimals"_a = 3, "The calendar date in a scale, correctly rounded to so many decimals.")
      .def(
          "mjd",
          [](const Instant& self, const std::string& scale) {
            const ModifiedJulianDate date = modified_julian_date(self, time_scale(scale));
            return std::pair(date.day, date.fraction);
          },
          "scale"_a = "TDB", "Modified Julian date in a scale: the whole day and the fraction of that day.")
      .def(
          "since_j2000",
          [](const Instant& self, const std::string& scale) { return pair_of(since_j2000(self, time_scale(scale))); },
          "scale"_a = "TT", "Seconds of a scale since 2000-01-01T12:00:00 on that scale, in two parts.")
      .def_prop_ro(
          "utc_doubt", [](const Instant& self) { return utc_doubt(self); },
          "Why UTC is in doubt at this instant, or None: before 1960, or years beyond the last known leap second.")
      .def("to_astropy", &astropy_time, nb::sig("def to_astropy(self) -> astropy.time.Time"), "As a Time, in TT.")
      .def(
          "__sub__", [](const Instant& a, const Instant& b) { return (a - b).high; }, nb::is_operator())
      .def(
          "__add__",
          [](const Instant& a, double seconds) {
            return a + Seconds{seconds, 0.0};
          },
          nb::is_operator())
      .def(
          "__sub__",
          [](const Instant& a, double seconds) {
            return a + Seconds{-seconds, 0.0};
          },
          nb::is_operator())
      .def(nb::self == nb::self, nb::sig("def __eq__(self, other: object, /) -> bool"))
      .def(nb::self < nb::self)
      .def("__hash__", [](const Instant& self) { return nb::hash(nb::cast(pair_of(self.tt_since_j2000()))); })
      .def("__repr__",
           [](const Instant& self) { return fmt::format("Instant('{} TDB')", format_date(self, TimeScale::tdb, 6)); });

  m.def(
      "leap_seconds",
      [] {
        std::vector<std::tuple<int, int, double>> table;
        for (const LeapSecond& row : leap_seconds()) table.emplace_back(row.year, row.month, row.tai_minus_utc_s);
        return table;
      },
      "The table in use: (year, month, TAI - UTC in seconds from the first day of that month on).");
  m.def(
      "set_leap_seconds", [](const Given<FileName>& kernel) { set_leap_seconds(read_leap_seconds(kernel->path)); },
      "kernel"_a,
      "Takes the table of leap seconds of a NAIF leap-second kernel, for the whole process. Call it before anything is "
      "read or converted. Raises InputError, FileError.");
  m.def("frame_rotation", &frame_rotation, "from_frame"_a, "to_frame"_a, "at"_a = nb::none(), "ut1_minus_utc_s"_a = 0.0,
        "pole_x_arcsec"_a = 0.0, "pole_y_arcsec"_a = 0.0,
        nb::sig("def frame_rotation(from_frame: str, to_frame: str, at: Instant | str | astropy.time.Time | "
                "collections.abc.Sequence[Instant | str] | None = None, ut1_minus_utc_s: float = 0.0, pole_x_arcsec: "
                "float = 0.0, pole_y_arcsec: float = 0.0) -> numpy.typing.NDArray[numpy.float64]"),
        "The rotation v_to = q v_from q* between two frames (ICRF, GCRF, EME2000, ECLIPJ2000, ECLIPIAU2006, TEME, "
        "ITRF) as "
        "a quaternion, scalar first: shape (4,), or (n, 4) for n instants. TEME and ITRF need `at`.");
}

}  // namespace polhode::python
