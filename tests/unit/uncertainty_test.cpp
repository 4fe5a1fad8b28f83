// Uncertainties of published numbers: what a change of each does at the epoch, against differences of clones (which go
// through the whole reader, the periods solved anew), and every refusal.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>

#include "polhode/base/error.hpp"
#include "polhode/body/invariants.hpp"
#include "polhode/motion/attitude_covariance.hpp"
#include "polhode/motion/free_body.hpp"
#include "polhode/motion/known_until.hpp"
#include "polhode/read/body.hpp"
#include "polhode/read/body_file.hpp"

namespace polhode {
namespace {

Body parse(const std::string& text) { return parse_body_file(text, "test.toml"); }

/// d f / d value of the published number at 0, of sixth order in `step`.
template <class Function>
auto difference(const Uncertainty& uncertainty, Eigen::Index number, double step, const Function& f) {
  const auto at = [&](int steps) {
    Eigen::VectorXd values = uncertainty.values();
    values[number] += steps * step;
    return f(uncertainty.body_with(values));
  };
  return ((45.0 * (at(1) - at(-1)) - 9.0 * (at(2) - at(-2)) + (at(3) - at(-3))) / (60.0 * step)).eval();
}

/// Compares every number's change with differences. `steps` is the step of each, as a part of its value (of 1 for 0).
void expect_differences(const std::string& text, double relative_step, double tolerance) {
  const Body body = parse(text);
  ASSERT_TRUE(body.uncertainty) << text;
  const Uncertainty& uncertainty = *body.uncertainty;
  const double rate = body.state->omega_named_rad_s->norm();
  const Quaternion attitude = body.state->q_frame_from_named.value().conjugate();
  for (std::size_t i = 0; i < uncertainty.numbers.size(); ++i) {
    const PublishedNumber& number = uncertainty.numbers[i];
    const double size = number.value == 0.0 ? 1.0 : std::abs(number.value), step = relative_step * size;
    const auto k = static_cast<Eigen::Index>(i);
    const Vector3 turn = difference(uncertainty, k, step, [&](const Body& clone) {
      return rotation_vector(attitude * *clone.state->q_frame_from_named);
    });
    const Vector3 omega =
        difference(uncertainty, k, step, [](const Body& clone) { return *clone.state->omega_named_rad_s; });
    const Matrix3 tensor =
        difference(uncertainty, k, step, [](const Body& clone) { return inertia_tensor(*clone.inertia); });
    EXPECT_LE((turn - number.change.turn_rad).norm() * size, tolerance * (1.0 + turn.norm() * size)) << number.name;
    EXPECT_LE((omega - number.change.omega_rad_s).norm() * size, tolerance * (rate + omega.norm() * size))
        << number.name;
    EXPECT_LE((tensor - number.change.tensor).norm() * size,
              tolerance * (inertia_tensor(*body.inertia).norm() + tensor.norm() * size))
        << number.name;
  }
}

const std::string begin = "name = 'a'\n";
const std::string moments = "[inertia]\nmoments = [2.1, 3.2, 4.0]\nmoments_sigma = [0.1, 0.1, 0.1]\nunit = 'kg m2'\n";
const std::string state = "[state]\nepoch = '2000-01-01T12:00:00 TT'\nframe = 'ICRF'\n";
const std::string angles =
    "[state.attitude]\neuler_angles = [30, 70, -20]\neuler_angles_sigma = [1, 2, 3]\nsequence = 'ZXZ'\nunit = 'deg'\n";
const std::string velocity_in = "components = [1.0, -0.4, 0.7]\ncomponents_sigma = [0.1, 0.2, 0.3]\nunit = ";

TEST(Uncertainty, ChangesOfAStateAreItsDerivatives) {
  expect_differences(
      begin + moments + state + angles + "[state.angular_velocity]\naxes = 'body'\n" + velocity_in + "'deg/s'\n", 1e-3,
      1e-11);
  expect_differences(
      begin + moments + state + angles + "[state.angular_velocity]\naxes = 'frame'\n" + velocity_in + "'deg/s'\n", 1e-3,
      1e-11);
  const std::string tensor =
      "[inertia]\ntensor = [[2.1, 0.2, -0.1], [0.2, 3.2, 0.3], [-0.1, 0.3, 4.0]]\n"
      "tensor_sigma = [[0.1, 0.1, 0.2], [0.1, 0.1, 0.1], [0.2, 0.1, 0.1]]\nunit = 'g cm2'\n";
  for (const char* axes : {"'body'", "'frame'"}) {
    expect_differences(begin + tensor + state + angles + "[state.angular_momentum]\naxes = " + axes + "\n" +
                           velocity_in + "'g cm2/s'\n",
                       1e-3, 1e-11);
  }
  const std::string products =
      "products = [0.2, 0.1, -0.1]\nproducts_sigma = [0.1, 0.1, 0.2]\nproducts_are = 'positive integrals'\n";
  expect_differences(begin + moments + products + state + angles + "[state.angular_momentum]\naxes = 'frame'\n" +
                         velocity_in + "'N m s'\n",
                     1e-3, 1e-11);
}

TEST(Uncertainty, ChangesOfQuaternionsAndSolidsAreTheirDerivatives) {
  for (const char* form : {"q_frame_from_body_scalar_first", "q_frame_from_body_scalar_last",
                           "q_body_from_frame_scalar_first", "q_body_from_frame_scalar_last"}) {
    const std::string attitude = std::string("[state.attitude]\n") + form + " = [0.5, -0.1, 0.7, 0.2]\n" + form +
                                 "_sigma = [0.1, 0.1, 0.1, 0.1]\n";
    for (const std::string solid : {"", "mass_kg = 3.0\nmass_kg_sigma = 0.1\nlength_unit = 'cm'\n",
                                    "density_kg_m3 = 2.0\ndensity_kg_m3_sigma = 0.1\nlength_unit = 'm'\n"}) {
      const std::string momentum_unit = solid.empty() ? "'ratios/s'\n" : "'N m s'\n";
      expect_differences(begin + "[inertia]\nsemi_axes = [3, 2, 1.5]\nsemi_axes_sigma = [0.1, 0.1, 0.1]\n" + solid +
                             state + attitude + "[state.angular_momentum]\naxes = 'frame'\n" + velocity_in +
                             momentum_unit,
                         1e-3, 1e-11);
    }
  }
}

std::string tumbling(const std::string& inertia, const std::string& convention, const std::string& mode,
                     const std::string& periods, const std::string& angle = "") {
  return begin + "[inertia]\n" + inertia + "unit = 'ratios'\n" +
         "[spin]\nepoch = 'JD 2455000.5 TDB'\nframe = 'ECLIPJ2000'\nunit = 'deg'\nlambda = 275.0\nlambda_sigma = 1\n"
         "beta = -75.0\nbeta_sigma = 2\nphi0 = 152.0\nphi0_sigma = 1\npsi0 = 14.0\npsi0_sigma = 2\nperiod_unit = "
         "'h'\n" +
         angle + "convention = '" + convention + "'\nmode = '" + mode + "'\n" + periods;
}

TEST(Uncertainty, ChangesOfPeriodsAreTheirDerivatives) {
  const std::string triaxial = "moments = [0.61, 0.965, 1.0]\nmoments_sigma = [0.1, 0.01, 0.01]\n";
  const std::string sigmas = "P_phi_sigma = 0.1\nP_psi_sigma = 1.0\n";
  const std::string both = sigmas + "P_phi = 27.38\nP_psi = 263.0\n";
  expect_differences(tumbling(triaxial, "long-axis", "short-axis", both), 1e-4, 2e-9);
  expect_differences(tumbling(triaxial, "long-axis", "long-axis", sigmas + "P_phi = 27.38\nP_psi = 80.0\n"), 1e-4,
                     2e-9);
  expect_differences(tumbling(triaxial, "short-axis", "short-axis", sigmas + "P_phi = 27.38\nP_psi = 300.0\n"), 1e-4,
                     2e-9);
  std::string swinging = tumbling(triaxial, "short-axis", "long-axis", sigmas + "P_phi = 12.0\nP_psi = 40.0\n");
  swinging.replace(swinging.find("psi0 = 14.0"), 11, "psi0 = 84.0");  // about 90 deg
  expect_differences(swinging, 1e-4, 2e-9);
  expect_differences(tumbling(triaxial, "long-axis", "short-axis", both, "theta0 = 100.0\ntheta0_sigma = 3\n"), 1e-4,
                     2e-9);
  // With products of inertia that turn the principal axes.
  expect_differences(
      tumbling("moments = [0.61, 0.93, 1.0]\nmoments_sigma = [0.1, 0.01, 0.01]\nproducts = [0.02, -0.01, 0.015]\n"
               "products_sigma = [0.1, 0.1, 0.1]\nproducts_are = 'tensor elements'\n",
               "long-axis", "short-axis", both),
      1e-4, 2e-9);
}

TEST(Uncertainty, ChangesOfSymmetricBodiesAreTheirDerivatives) {
  // Without sigmas of the moments: other moments would break the symmetry, and with it the order of the axes.
  const std::string sigmas = "P_phi_sigma = 0.1\nP_psi_sigma = 1.0\n";
  for (const auto& [inertia, convention, mode] :
       {std::array<std::string, 3>{"moments = [0.6, 1.0, 1.0]\n", "long-axis", "long-axis"},
        std::array<std::string, 3>{"moments = [0.7, 0.7, 1.0]\n", "short-axis", "short-axis"}}) {
    expect_differences(tumbling(inertia, convention, mode, sigmas + "P_phi = 10.0\nP_psi = 40.0\n"), 1e-4, 2e-5);
  }
  expect_differences(begin +
                         "[spin]\nepoch = 'JD 2455000.5 TDB'\nframe = 'ECLIPJ2000'\nunit = 'deg'\nlambda = 275.0\n"
                         "lambda_sigma = 1\nbeta = -75.0\nbeta_sigma = 2\nphi0 = 152.0\nphi0_sigma = 1\nperiod = 5.0\n"
                         "period_sigma = 0.01\nperiod_unit = 'h'\n",
                     1e-3, 1e-11);
}

TEST(Uncertainty, EnergyHasThatOfItsInputs) {
  const Body body =
      parse(tumbling("moments = [0.61, 0.965, 1.0]\nmoments_sigma = [0.03, 0.004, 0]\n", "long-axis", "short-axis",
                     "P_phi = 27.38\nP_psi = 263.0\nP_phi_sigma = 0.02\nP_psi_sigma = 2\n"));
  const Uncertainty& uncertainty = *body.uncertainty;
  double variance = 0.0;
  for (Eigen::Index i = 0; i < uncertainty.values().size(); ++i) {
    const double size = std::max(1.0, std::abs(uncertainty.values()[i]));
    const auto slope = difference(uncertainty, i, 1e-4 * size, [](const Body& clone) {
      return Eigen::Matrix<double, 1, 1>(
          spin_invariants(*clone.inertia, momentum_principal(clone)).energy_above_ground);
    });
    variance += slope[0] * slope[0] * uncertainty.covariance(i, i);
  }
  EXPECT_NEAR(energy_sigma(body), std::sqrt(variance), 1e-7 * std::sqrt(variance));
}

TEST(Uncertainty, CovarianceStandsInsteadOfSigmas) {
  const std::string body_text =
      begin + moments + state + angles + "[state.angular_velocity]\naxes = 'body'\n" + velocity_in + "'deg/s'\n";
  const Body body = parse(body_text +
                          "[uncertainty]\nparameters = ['components.z', 'moments.x']\n"
                          "covariance = [[0.09, 0.01], [0.01, 0.01]]\n");
  const Uncertainty& uncertainty = *body.uncertainty;
  ASSERT_EQ(uncertainty.numbers.size(), 9U);
  EXPECT_EQ(uncertainty.numbers[0].name, "moments.x");
  EXPECT_EQ(uncertainty.numbers[8].name, "components.z");
  EXPECT_EQ(uncertainty.covariance(0, 8), 0.01);
  EXPECT_EQ(uncertainty.covariance(8, 0), 0.01);
  EXPECT_EQ(uncertainty.covariance(7, 7), 0.2 * 0.2);
  const Eigen::MatrixXd root = uncertainty.root();
  EXPECT_LE((root * root.transpose() - uncertainty.covariance).norm(), 1e-15);
  EXPECT_FALSE(parse(begin + "[inertia]\nmoments = [2, 3, 4]\nunit = 'kg m2'\n").uncertainty);
}

TEST(Uncertainty, RefusesWithFileAndLine) {
  const std::string good = begin + moments + state + angles + "[state.angular_velocity]\naxes = 'body'\n" +
                           velocity_in + "'deg/s'\n";  // 18 lines
  const auto message = [&](const std::string& text) -> std::string {
    try {
      parse(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "nothing";
  };
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  EXPECT_EQ(
      message(replaced("euler_angles_sigma = [1, 2, 3]", "euler_angles_sigma = [1, -2, 3]")),
      "test.toml:11: state.attitude.euler_angles_sigma: found -2, an uncertainty of 0 or more is wanted, up to 1e100");
  EXPECT_EQ(message(replaced("euler_angles_sigma = [1, 2, 3]", "euler_angles_sigma = [1, 1e200, 3]")),
            "test.toml:11: state.attitude.euler_angles_sigma: found 1e+200, an uncertainty of 0 or more is wanted, up "
            "to 1e100");
  EXPECT_EQ(message(replaced("euler_angles_sigma = [1, 2, 3]", "euler_angles_sigma = 1")),
            "test.toml:11: state.attitude.euler_angles_sigma: found the number 1, a list of 3 numbers is wanted");
  EXPECT_EQ(message(replaced("moments_sigma = [0.1, 0.1, 0.1]", "moments_sigma = [0.1, inf, 0.1]")),
            "test.toml:4: inertia.moments_sigma: found the number inf, a finite number is wanted");
  EXPECT_EQ(message(replaced("moments_sigma", "products_sigma")),
            "test.toml:4: inertia.products_sigma: goes with products, which is not given");
  const auto with = [&](const std::string& parameters, const std::string& covariance) {
    return message(good + "[uncertainty]\nparameters = " + parameters + "\ncovariance = " + covariance + "\n");
  };
  const std::string place = "test.toml:21: uncertainty.covariance: ";
  EXPECT_EQ(with("['components.x']", "[[-0.01]]"),
            place + "the variance of components.x is -0.01; 0 or more is wanted");
  EXPECT_EQ(with("['components.x']", "[[0.01, 0.0]]"),
            place + "found a list of 2 in the place of a row, 1 rows of 1 numbers are wanted");
  EXPECT_EQ(with("['moments.x', 'moments.y']", "[[0.01, 0.001], [0.0, 0.01]]"),
            place + "the covariance is not symmetric: of moments.x and moments.y it holds 0.001 and 0");
  EXPECT_EQ(with("['moments.x', 'moments.y']", "[[0.01, 0.02], [0.02, 0.01]]"),
            place + "the covariance of moments.x and moments.y is 0.02, more than their sigmas allow: 0.01");
  EXPECT_EQ(
      with("['moments.x', 'moments.y', 'moments.z']", "[[0.01, 0.009, 0.0], [0.009, 0.01, 0.009], [0.0, 0.009, 0.01]]"),
      place + "the covariance is not positive semidefinite: its correlations have the eigenvalue -0.273");
  EXPECT_EQ(with("['components.x']", "[[0.04]]"),
            place + "of components.x it gives a sigma of 0.2, beside the number stands 0.1");
  EXPECT_EQ(with("['P_psi']", "[[0.01]]").substr(0, 94),
            "test.toml:20: uncertainty.parameters: 'P_psi' is no number of this file; allowed are moments.x");
  EXPECT_EQ(with("['components.x', 'components.x']", "[[1, 0], [0, 1]]"),
            "test.toml:20: uncertainty.parameters: 'components.x' stands there twice");
  EXPECT_EQ(
      message("period_uncertainty = 1e-3\n" + good),
      "test.toml:1: period_uncertainty: cannot stand beside an uncertainty of components.x; one of them is enough");
}

TEST(Uncertainty, PeriodsAreASpecialCase) {
  Body body = parse("period_uncertainty = 1e-3\n" + begin + "[inertia]\nmoments = [2, 3, 4]\nunit = 'kg m2'\n" + state +
                    "[state.attitude]\neuler_angles = [1, 2, 3]\nsequence = 'ZXZ'\nunit = 'deg'\n"
                    "[state.angular_velocity]\naxes = 'body'\nunit = 'rad/s'\ncomponents = [0.5, 0.1, 2.0]\n");
  ASSERT_TRUE(body.uncertainty);
  EXPECT_EQ(period_uncertainty(body), 1e-3);
  const FreeBody free = free_body(body);
  const ThetaMotion motion(free);
  const AttitudeCovariance covariance(body);
  for (const double t_s : {-70.0, 0.0, 3.0, 500.0}) {  // time itself is uncertain by that part
    const double rate = named_state(free, motion.at(t_s)).omega_named_rad_s.norm();
    EXPECT_NEAR(covariance.sigma_rad(t_s), 1e-3 * std::abs(t_s) * rate, 1e-12 * (1.0 + std::abs(t_s)));
  }
  set_period_uncertainty(body, 2e-3);
  EXPECT_EQ(period_uncertainty(body), 2e-3);
  const double sigma = AttitudeCovariance(body).sigma_rad(500.0);
  EXPECT_NEAR(sigma, 2.0 * covariance.sigma_rad(500.0), 1e-12);
  const double known_s = known_until_s(body, AttitudeCovariance(body), 0.1);
  EXPECT_NEAR(AttitudeCovariance(body).sigma_rad(known_s), 0.1, 1e-6);
  Eigen::VectorXd longer(1);
  longer << 0.25;
  EXPECT_LE((*body.uncertainty->body_with(longer).state->omega_named_rad_s - Vector3(0.4, 0.08, 1.6)).norm(), 1e-15);
}

TEST(Uncertainty, CovarianceOfTheAttitudeIsThatOfDisplacedMotions) {
  const std::string products =
      "products = [0.2, 0.1, -0.1]\nproducts_sigma = [0.02, 0.01, 0.02]\nproducts_are = 'tensor elements'\n";
  for (const std::string& inertia :
       {moments, moments + products,
        std::string("[inertia]\nmoments = [2, 2, 3]\nproducts = [0, 0, 0]\nproducts_are = "
                    "'tensor elements'\nproducts_sigma = [0.1, 0.1, 0.1]\nunit = 'kg m2'\n")}) {
    const Body body = parse(begin + inertia + state + angles + "[state.angular_velocity]\naxes = 'body'\n" +
                            velocity_in + "'deg/s'\n");
    const AttitudeCovariance covariance(body);
    const auto attitude = [](const Body& of, double t_s) {
      const FreeBody free = free_body(of);
      return named_state(free, ThetaMotion(free).at(t_s)).q_inertial_from_named;
    };
    for (const double t_s : {0.0, 40.0, -900.0, 20000.0}) {
      const Quaternion centre = attitude(body, t_s).conjugate();
      const Uncertainty& uncertainty = *body.uncertainty;
      Matrix3 sum = Matrix3::Zero();
      for (Eigen::Index i = 0; i < uncertainty.values().size(); ++i) {
        const double step = 1e-6 * (1.0 + std::abs(uncertainty.values()[i]));
        const Vector3 turn = difference(
            uncertainty, i, step, [&](const Body& clone) { return rotation_vector(centre * attitude(clone, t_s)); });
        sum += uncertainty.covariance(i, i) * turn * turn.transpose();
      }
      EXPECT_LE((covariance.at(t_s) - sum).norm(), 2e-5 * sum.norm()) << inertia << t_s;
    }
    // A batch says the same, on any number of threads.
    const std::vector<double> times{0.0, 40.0, -900.0, 20000.0, 1e6};
    std::vector<double> sigma(5), six(30), sigma_2(5), six_2(30);
    covariance.batch({times}, sigma, six);
    batch_threads(covariance, {times}, sigma_2, six_2, 3);
    EXPECT_EQ(sigma, sigma_2);
    EXPECT_EQ(six, six_2);
    for (std::size_t i = 0; i < times.size(); ++i) {
      const Matrix3 one = covariance.at(times[i]);
      EXPECT_NEAR(sigma[i], covariance.sigma_rad(times[i]), 1e-12 * sigma[i]);
      EXPECT_NEAR(six[6 * i + 4], one(1, 2), 1e-12 * one.norm());
    }
    EXPECT_THROW(covariance.batch({times}, std::span(sigma).first(4), six), InputError);
  }
}

}  // namespace
}  // namespace polhode
