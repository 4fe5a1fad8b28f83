#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "polhode/body/body.hpp"

namespace polhode {
class KeplerOrbit;
class Torques;
}  // namespace polhode

namespace polhode::taylor {

inline constexpr int kMostOrder = 36;
inline constexpr int kStateColumns = 6;  ///< of the partial derivatives
inline constexpr int kMostVectors = 4;   ///< of a state: the rate, and two or three fixed axes seen from the body

/// A number as a sum of two.
struct TwoParts {
  double high = 0.0, low = 0.0;
  explicit operator double() const { return high; }
};

/// The body and its torques in numbers; x, y, z are the principal axes.
struct BodyNumbers {
  long double euler_weights[3] = {};  ///< (I2 - I3)/I1, ...
  long double constant[3] = {};       ///< the torque that keeps its components, over the moments
  long double damping[3][3] = {};     ///< [column][row] of -D, over the moments

  long double outside[3] = {};             ///< the torque that keeps its components along the fixed axes
  long double inverse_moments[3] = {};     ///< beside the first
  long double slip_weights[3] = {};        ///< k (I2 - I3), ..., with k of internal dissipation times the unit of rate
  long double moments[3] = {};             ///< over the first
  long double magnetic_tensor[3][3] = {};  ///< [column][row] of M, over the first moment: B^2 times it is a rate

  /// (these - others) / by
  BodyNumbers change_from(const BodyNumbers& others, long double by) const;
};

/// The unit of time is `unit_s`, a power of two.
struct Equations : BodyNumbers {
  double unit_s = 1.0;

  /// Of what else moves: series of the tide and of a magnetic field are found from these.
  const Torques* torques = nullptr;

  /// The only point mass, and the orbit about it.
  struct Orbit {
    const KeplerOrbit* orbit = nullptr;
    double eccentricity = 0.0;
    long double parameter_m = 0.0;
    long double rate = 0.0;  ///< sqrt(mu/parameter^3)
    double dipole[3] = {};   ///< field of a dipole there, on its equator at the distance of the parameter
  } orbit;

  /// Which torques there are: the entry of kEntries in run.hpp.
  int kinds = 0;
};

/// The equations of a body under torques in principal axes. fixed_axes() are those that its torques from outside are
/// given along: of the orbit, if all depends on one, else of the inertial frame.
Equations equations_of(const Eigen::Matrix<long double, 3, 1>& I, const Torques& torques, double unit_s);
Eigen::Matrix<long double, 3, 3> fixed_axes(const Torques& torques);
/// Whether all torques have series.
bool have_series(const Torques& torques);

/// Where a run has come to.
struct Front {
  double high[kMostVectors][4] = {}, low[kMostVectors][4] = {};
  /// How far the run is from the motion, to first order: what the steps and their roundings left out, carried along.
  double rate_error[4] = {}, turn_error_rad[4] = {};
  double t_high = 0.0, t_low = 0.0;
  long double orbit[3] = {};  ///< cosine and sine of the true anomaly, and sqrt(parameter/distance)
  int until_exact_orbit = 0;  ///< steps until it is computed anew
  double longest = 0.0;       ///< the next step must not be longer
  unsigned long long random = 0x9e3779b97f4a7c15ull;
  double worst_rad = 0.0;  ///< largest turn_error_rad so far
};

/// What a series is made from. The step ends where the next one starts.
struct StepStart {
  double t_high, t_low;
  double state[kMostVectors][3];
  double orbit[3];
  int order;
  int direction;  ///< of time: 1 or -1
  int sign = 1;   ///< of the quaternion
};

/// How a run takes its steps.
struct Stepping {
  double end;          ///< in units, either side of the front
  double local_error;  ///< allowed in a step
  int order;
  bool precise;  ///< low orders in double-double
};

/// Series in time of what the torques from outside depend on, along the fixed axes.
struct Surroundings {
  double tide[6][kMostOrder + 1];    ///< sum of 3 mu r r^T/r^5: 11, 22, 33, 23, 31, 12
  double field[3][kMostOrder + 1];   ///< magnetic, over the unit of the tensor
  double change[3][kMostOrder + 1];  ///< of the field
  double longest;                    ///< how far they hold
};
/// About the start of a step (surroundings.cpp).
void find_surroundings(const Equations& equations, const StepStart& start, int order, double longest,
                       Surroundings& out);
/// The orbit at a time, in the form of Front::orbit.
void exact_orbit(const Equations& equations, double t_high, double t_low, long double (&state)[3]);

/// A small change of the state: of the rate, and a small turn in the body's axes.
struct StateChange {
  double rate[4] = {}, turn_rad[4] = {};
};

/// What a parameter's growth by one makes of the equations.
struct ParameterChange {
  BodyNumbers numbers;
  /// Of the series of the tide, of the field and of the field's own change: by these shares of themselves, and as if
  /// time since `from` went faster by `haste`. It is those of `torques`, or of all if that is null.
  double tide = 0.0, field = 0.0, own_change = 0.0, haste = 0.0, from = 0.0;
  const Torques* torques = nullptr;
};

struct Kernel {
  const char* name;
  /// Takes up to `most` steps, as far as the end; returns how many.
  int (*advance)(const Equations& equations, const Stepping& stepping, int most, Front& front, StepStart* starts);
  /// The coefficients of the state, [order][vector][component], order + 1 of them.
  void (*coefficients)(const Equations& equations, const StepStart& start, int order, double length,
                       double (*out)[kMostVectors][4]);
  /// From what the state has changed by at the start of a step, the same at times since then: [time][column]. Column k
  /// is for no parameter below kStateColumns, then for each parameter.
  void (*vary)(const Equations& equations, const StepStart& start, double length,
               std::span<const ParameterChange> parameters, const StateChange* starts, std::span<const double> times,
               StateChange* out);
  /// The state at a time since the start of the step.
  void (*evaluate)(const double (*coefficients)[kMostVectors][4], int order, double t, double (*state)[4]);
};

/// For the instruction set of ThetaMotion::best_target().
const Kernel& best_kernel();
/// All that this machine has, the simplest first.
std::vector<const Kernel*> kernels();

}  // namespace polhode::taylor
