#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polhode/body/inertia.hpp"
#include "polhode/body/spin_solution.hpp"
#include "polhode/frames/frame.hpp"
#include "polhode/motion/motion.hpp"
#include "polhode/motion/torqued_partials.hpp"
#include "polhode/observe/scattering.hpp"
#include "polhode/observe/shape.hpp"
#include "polhode/observe/sight.hpp"

namespace polhode {

/// A body's motion with all that relates it to the sky.
struct ObservedMotion {
  std::shared_ptr<const Motion> motion;  ///< of the principal axes
  Frame frame = Frame::icrf;             ///< inertial, of its states
  Instant epoch;                         ///< where its clock is 0
  Matrix3 named_from_principal = Matrix3::Identity();
  Vector3 principal_moments = Vector3::Ones();
};

/// How bright the body is.
struct Photometry {
  std::shared_ptr<const Shape> shape;
  ScatteringLaw law;
  PhaseFunction phase;
  /// Absolute magnitude, of the mean of all directions at phase 0. Magnitudes are relative without it: as if it were 0.
  std::optional<double> absolute_magnitude;
};

/// Throws InputError for an absolute magnitude beyond +-100, for what check() of a phase function refuses, for a
/// specular part of a shape without mirrors, and for mirrors beside a law without Lambert's part.
void check(const Photometry& photometry);

struct ObservationOptions {
  AxisConvention convention = AxisConvention::long_axis;
  Frame angles_frame = Frame::ecliptic_j2000;  ///< inertial, in which phi counts: see AspectFrame
  bool geometry = true;                        ///< the columns of geometry
  std::optional<Photometry> photometry;        ///< the columns magnitude and area_m2
  double exposure_s = 0.0;                     ///< times are the middles of exposures that last so long
  unsigned threads = 0;                        ///< 0: all
};

/// A column of what is seen; each value belongs to an instant.
struct ObservedColumn {
  std::string name;  ///< with its unit: "range_m"
  std::vector<double> values;
};

/// What an observer sees at instants of reception, in any order: `sight_of` gives the sight at each of them, also of
/// those within an exposure if there is one. The state is that at emission. An exposure sums the light over its span,
/// by Gauss's quadrature with 4 points at least for each 0.2 rad that the body turns, or, where the shape has mirrors,
/// for a quarter of the Sun's radius: a glint is good to a few hundredths. The geometry is that of its middle. Throws
/// InputError where the motion or a trajectory does not hold an instant, for what check() of the photometry refuses, an
/// exposure in which the body turns too far to be followed, and an observer within the body; ComputationError for a
/// magnitude that is no number. A body of which nothing is both lit and seen has the magnitude +infinity.
std::vector<ObservedColumn> observe(const ObservedMotion& body, std::span<const Instant> receptions,
                                    const std::function<Sight(std::size_t index, Instant reception)>& sight_of,
                                    const ObservationOptions& options);

/// The names of the columns that observe() gives, in order.
std::vector<std::string> observed_columns(const ObservationOptions& options);

/// The parameters of observe_partials(), in order: those of the states; "axes_x", "axes_y", "axes_z", a small turn of
/// the principal axes in the named ones, whose motion stays as it is (rad, named axes); with photometry "scale", the
/// relative change of all lengths of the shape.
std::vector<std::string> observed_parameters(const StatePartialsSource& states_by, const ObservationOptions& options);

/// Whether a number of observe() has a derivative by the attitude: not one that is none itself, nor within 0.115 deg
/// (2e-3 rad) of a pole: longitudes and latitudes there, position and aspect angles of an axis that points at the
/// observer or away, phi, theta, psi of a rotation about the axis that they count from.
bool has_derivative(std::span<const ObservedColumn> columns, std::size_t column, std::size_t row);

/// The derivatives of the columns of observe() by these parameters, in the columns' units: as many numbers for each
/// instant as there are parameters. By the state at emission through differences of fourth order (1e-12 of their size
/// where a column is smooth), by the parameters through the states' own partials. The brightness of a mesh has kinks
/// where facets turn into the light: there its slope is a mean over 2e-3 rad. NaN where there is no derivative
/// (has_derivative()). Throws as observe().
std::vector<ObservedColumn> observe_partials(const ObservedMotion& body, std::span<const Instant> receptions,
                                             const std::function<Sight(std::size_t index, Instant reception)>& sight_of,
                                             const ObservationOptions& options, const StatePartialsSource& states_by);

}  // namespace polhode
