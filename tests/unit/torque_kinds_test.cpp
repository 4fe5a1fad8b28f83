#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <random>
#include <sstream>
#include <string>

#include "polhode/body/inertia.hpp"
#include "polhode/read/scene_file.hpp"
#include "polhode/torque/torques.hpp"

// What holds for every kind of torque, whoever adds one.

namespace polhode {
namespace {

/// The table of each kind in a scene.
const std::map<std::string, std::string, std::less<>>& samples() {
  static const std::map<std::string, std::string, std::less<>> all{
      {"gravity gradient", "orbit = 'earth'"},
      {"constant", "torque_n_m = [3.0, -1.0, 2.0]\naxes = 'frame'"},
      {"thruster pulse", "torque_n_m = [3.0, -1.0, 2.0]\nstart_s = 100\nduration_s = 3000"},
      {"linear damping", "coefficient_n_m_s = 20"},
      {"eddy currents",
       "magnetic_tensor_s_m4 = [[3e6, 1e5, 0], [1e5, 4e6, -2e5], [0, -2e5, 5e6]]\ndipole_t_m3 = 7.8e15\n"
       "dipole_axis = [0.1, -0.2, -1]\norbit = 'earth'"},
      {"internal dissipation", "quality_factor = 100"},
      {"sunlight", "mesh = '" POLHODE_DATA_DIR
                   "/samples/mesh/box.obj'\nunit_m = 1\ncentre_of_mass = 'mesh origin'\nspecular = 0.3\ndiffuse = 0.5\n"
                   "orbit = 'sun'\nshadow_orbit = 'earth'\nshadow_radius_m = 6.378e6"},
      {"aerodynamic", "mesh = '" POLHODE_DATA_DIR
                      "/samples/mesh/box.obj'\nunit_m = 1\ncentre_of_mass = [0.3, 0.1, -0.2]\naccommodation = 0.9\n"
                      "rebound_speed = 0.1\norbit = 'earth'\ndensity_kg_m3 = 1e-12\ndistance_m = 7.2e6\n"
                      "scale_height_m = 1e5\nturn_rad_s = 7.292115e-5\nturn_axis = [0, 0, 2]"}};
  return all;
}

constexpr double kSpan_s = 7000.0;

Torque read_sample(std::string_view kind) {
  const std::string scene = "name = 'x'\nsource = 'y'\nbody = '" POLHODE_DATA_DIR
                            "/bodies/envisat.toml'\nframe = 'ICRF'\nafter = '7000 s'\naccuracy = '1 deg'\n"
                            "[orbit.earth]\nmu_m3_s2 = 3.986004418e14\nperiapsis_m = 7.1e6\neccentricity = 0.1\n"
                            "periapsis_after_epoch_s = 500\nto_periapsis = [1, 0, 0]\nnormal = [0, 0.6, 0.8]\n"
                            "[orbit.sun]\nmu_m3_s2 = 1.32712440018e20\nperiapsis_m = 1.47e11\neccentricity = 0.0167\n"
                            "periapsis_after_epoch_s = 0\nto_periapsis = [1, 0, 0]\nnormal = [0, -0.4, 0.9165]\n"
                            "[[torque]]\nkind = '";
  return parse_scene(scene + std::string(kind) + "'\n" + samples().find(kind)->second + "\n", "scene", read_text_file)
      .torques.list()
      .front();
}

class EveryKind : public ::testing::Test {
 protected:
  template <class Check>
  void each(const Check& check) {
    for_each_torque_kind([&]<class Kind>() {
      SCOPED_TRACE(Kind::name);
      if (!samples().contains(Kind::name)) {
        ADD_FAILURE() << "a kind of torque without a sample here";
        return;
      }
      check(std::get<Kind>(read_sample(Kind::name)));
    });
  }

  double number(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Vector3 vector() { return {number(-1, 1), number(-1, 1), number(-1, 1)}; }
  Quaternion attitude() { return Quaternion(number(-1, 1), number(-1, 1), number(-1, 1), number(-1, 1)).normalized(); }

  /// With the change of the momentum in the body that internal dissipation is.
  static Vector3 effect(const Torque& torque, double t_s, const Quaternion& q, const Vector3& moments,
                        const Vector3& momentum) {
    const Vector3 omega = momentum.cwiseQuotient(moments);
    const TorqueTerms<double> terms = Torques({torque}).during(t_s).at(t_s, q, moments);
    return terms.torque(omega) + terms.relaxation * momentum.cross(momentum.cross(omega));
  }

  const Vector3 moments_{17000.0, 124800.0, 129100.0};
  std::mt19937_64 random_{20261129};
};

TEST_F(EveryKind, FeelsTheSameInOtherAxes) {
  Matrix3 cycle;  // of the principal axes, so that the moments can be turned with them
  cycle << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  each([&](const auto& torque) {
    for (int n = 0; n < 100; ++n) {
      const double t_s = number(0.0, kSpan_s);
      const Quaternion q = attitude();
      const Vector3 momentum = 1e4 * vector();
      const Vector3 there = effect(torque, t_s, q, moments_, momentum);
      const Vector3 here =
          effect(torque.turned(cycle), t_s, q * Quaternion(cycle).conjugate(), cycle * moments_, cycle * momentum);
      EXPECT_LE((here - cycle * there).norm(), 1e-12 * there.norm()) << t_s;
    }
  });
}

TEST_F(EveryKind, IsNeverLargerThanItsLargest) {
  each([&](const auto& torque) {
    double nearest = 0.0;
    for (int n = 0; n < 5000; ++n) {
      const double t_s = number(0.0, kSpan_s);
      const Vector3 momentum = 1e4 * vector();
      const double felt = effect(torque, t_s, attitude(), moments_, momentum).norm();
      const double largest = torque.largest(t_s, moments_, momentum.norm());
      EXPECT_LE(felt, largest * (1.0 + 1e-12)) << t_s;
      if (largest > 0.0) nearest = std::max(nearest, felt / largest);
    }
    EXPECT_GE(nearest, 0.05);  // a bound that means something
  });
}

TEST_F(EveryKind, StandsInTheManualWithItsKeys) {
  std::ifstream file(POLHODE_DATA_DIR "/../tools/manual/scenes.md");
  std::stringstream manual;
  manual << file.rdbuf();
  each([&](const auto& torque) {
    const std::string text = manual.str(), begin = "| " + std::string(torque.name) + " |";
    const std::size_t at = text.find(begin);
    ASSERT_NE(at, std::string::npos) << "no row in tools/manual/scenes.md";
    const std::string row = text.substr(at, text.find('\n', at) - at);
    for (const std::string_view key : torque.keys) EXPECT_NE(row.find(key), std::string::npos) << key;
  });
}

}  // namespace
}  // namespace polhode
