#pragma once

#include <memory>

#include "polhode/elliptic/jacobi.hpp"
#include "polhode/motion/motion.hpp"

// The two earlier approaches that Leroy (2020), "On an Article by Celledoni et al.", corrects and gives up: kept to
// show where they fail. Plain double, no scaling of units. "CFSZ07" is Celledoni, Fasso, Saefstroem & Zanna, "The exact
// computation of the free rigid body motion and its use in splitting methods", preprint 2007.

namespace polhode::rivals {

/// The solution of Euler's equation as Leroy gives it, "Solution of Euler's equation": the three cases with his signs
/// of lambda and of case (iii), his nu, and with w = lambda t - nu.
class EulerSolution {
 public:
  enum class Case { i, ii, iii };

  explicit EulerSolution(const FreeBody& body);

  struct Sample {
    Vector3 m;             ///< momentum in the principal axes
    double w;              ///< lambda t - nu
    double half_periods;   ///< whole steps 2 K taken from w; 0 in case (iii)
    JacobiValues reduced;  ///< sn, cn >= 0, dn of the rest; unused in case (iii)
  };
  Sample at(double t_s) const;

  /// Pi(am w, n, k), and arctg(c sc w) continued from branch to branch: cases (i) and (ii).
  double third_kind(const Sample& s, double n, double one_minus_n) const;
  static double arctg_sc(const Sample& s, double c);

  Vector3 I;
  double G = 0, twice_energy = 0, Delta1 = 0, Delta2 = 0, Delta3 = 0;
  double B13 = 0, B31 = 0, B21 = 0, B23 = 0;
  double lambda = 0, nu = 0;
  double sigma = 1;      ///< cases (i), (ii): sign of the component with dn; case (iii): sigma'', the sign of m3
  double sigma_one = 1;  ///< case (iii): sigma', the sign of m1
  Case which = Case::iii;
  double kc = 1;  ///< sqrt(m_c); unused in case (iii)

 private:
  double phase(const Vector3& m0) const;

  Jacobi jacobi_{1.0};
};

/// CFSZ07's matrix form: the basis {m, dm/dt, m x dm/dt}, which is lost where dm/dt vanishes.
std::unique_ptr<Motion> make_matrix_basis(const FreeBody& body);

/// CFSZ07's quaternion form: m turned onto e3 in every case, which is lost where m3 = -G.
std::unique_ptr<Motion> make_cfsz_quaternion(const FreeBody& body);

}  // namespace polhode::rivals
