// Files of scenes: what they mean, and what is refused at which line.
#include "polhode/read/scene_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <variant>
#include <vector>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

TEST(Scenes, SayWhereTheCentreOfMassOfAMeshIs) {
  const std::string path = ::testing::TempDir() + "polhode_scene_mesh_test.toml";
  const auto scene = [&](const std::string& centre) {
    std::ofstream(path) << "name = 'x'\nsource = 'y'\nbody = '" POLHODE_DATA_DIR
                           "/bodies/envisat.toml'\nframe = 'ICRF'\nafter = '1 d'\naccuracy = '1 deg'\n"
                           "[orbit.sun]\nmu_m3_s2 = 1.32712440018e20\nperiapsis_m = 1.5e11\neccentricity = 0\n"
                           "periapsis_after_epoch_s = 0\nto_periapsis = [1, 0, 0]\nnormal = [0, 0, 1]\n"
                           "[[torque]]\nkind = 'sunlight'\nmesh = '" POLHODE_DATA_DIR
                           "/samples/mesh/box.obj'\nunit_m = 1\nspecular = 0\ndiffuse = 0\norbit = 'sun'\n"
                        << centre;
    return read_scene(path);
  };
  const auto torque = [&](const std::string& centre, const Vector3& to_sun_m) {
    return std::get<Sunlight>(scene("centre_of_mass = '" + centre + "'\n").torques.list()[0]).torque(to_sun_m);
  };
  // The box of 1 x 2 x 3 has its origin at a corner: light that presses on its middle turns it about the corner only.
  const Vector3 sun(1.4e11, 0.3e11, 0.2e11);
  EXPECT_LT(torque("mesh centroid", sun).norm(), 1e-18);
  const Vector3 about_origin = torque("mesh origin", sun), centroid(0.5, 1.0, 1.5);
  EXPECT_GT(about_origin.norm(), 1e-7);
  EXPECT_LT(std::abs(about_origin.dot(centroid)), 1e-12 * about_origin.norm());
  EXPECT_LT(std::abs(about_origin.dot(sun.normalized())), 1e-12 * about_origin.norm());

  const auto complaint = [&](const std::string& centre) -> std::string {
    try {
      scene(centre);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no InputError";
  };
  for (const char* wrong : {"", "centre_of_mass = 'the middle'\n"}) {
    EXPECT_NE(complaint(wrong).find("'mesh origin'"), std::string::npos) << complaint(wrong);
    EXPECT_NE(complaint(wrong).find("'mesh centroid'"), std::string::npos) << complaint(wrong);
    EXPECT_NE(complaint(wrong).find(path + ":"), std::string::npos) << complaint(wrong);
  }
  std::filesystem::remove(path);
}

TEST(Scenes, RefuseTorquesThatMeanNothingAtTheirLine) {
  const std::string path = ::testing::TempDir() + "polhode_scene_torque_test.toml";
  std::ofstream(path)
      << "name = 'x'\nsource = 'y'\nbody = '" POLHODE_DATA_DIR
         "/bodies/envisat.toml'\nframe = 'ICRF'\nafter = '1 d'\naccuracy = '1 deg'\n"
         "[[torque]]\nkind = 'thruster pulse'\ntorque_n_m = [1, 2, 3]\nstart_s = 1e20\nduration_s = 1\n";
  try {
    read_scene(path);
    FAIL();
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_EQ(message.find(path + ":8: "), 0U) << message;
    EXPECT_NE(message.find("thruster pulse: a pulse of 1 s that starts at 1e+20 s"), std::string::npos) << message;
  }
  std::filesystem::remove(path);
}

TEST(Scenes, SayWhichElementOfAnOrbitIsWrongAtItsLine) {
  const std::string path = ::testing::TempDir() + "polhode_scene_orbit_test.toml";
  const std::string head = "name = 'x'\nsource = 'y'\nbody = '" POLHODE_DATA_DIR
                           "/bodies/envisat.toml'\nframe = 'ICRF'\nafter = '1 d'\naccuracy = '1 deg'\n[orbit.earth]\n";
  struct Element {
    std::string key, right, wrong, message;
  };
  const std::vector<Element> elements{
      {"mu_m3_s2", "3.986e14", "-1", "found -1, a positive number is wanted"},
      {"periapsis_m", "7e6", "0", "the periapsis distance is 0, a positive number of m is wanted"},
      {"eccentricity", "0.1", "-0.1", "the eccentricity is -0.1, 0 or more is wanted"},
      {"periapsis_after_epoch_s", "0", "1e16",
       "the time of periapsis is 1e+16 s, from -1e+12 s to 1e+12 s is wanted: of times much longer a double does not "
       "hold the phase on an orbit"},
      {"to_periapsis", "[1, 0, 0]", "[0, 0, 0]",
       "the direction of periapsis is (0, 0, 0), a finite vector other than 0 is wanted"},
      {"normal", "[0, 0, 1]", "[1, 0, 1]",
       "the orbit normal (1, 0, 1) is 0.79 rad from a right angle to the direction of periapsis (1, 0, 0); at most "
       "0.0002 rad is allowed, what four decimals hold"}};
  for (std::size_t wrong = 0; wrong < elements.size(); ++wrong) {
    std::string text = head;
    for (std::size_t i = 0; i < elements.size(); ++i) {
      text += elements[i].key + " = " + (i == wrong ? elements[i].wrong : elements[i].right) + "\n";
    }
    std::ofstream(path) << text;
    try {
      read_scene(path);
      ADD_FAILURE() << elements[wrong].key << " is accepted";
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()), path + ":" + std::to_string(8 + wrong) + ": orbit.earth." +
                                               elements[wrong].key + ": " + elements[wrong].message);
    }
  }
  std::filesystem::remove(path);
}

TEST(Scenes, ALackOfSunlightIsLocatedOnce) {
  const std::string path = ::testing::TempDir() + "polhode_scene_sunlight_test.toml";
  std::ofstream(path) << "name = 'x'\nsource = 'y'\nbody = '" POLHODE_DATA_DIR
                         "/bodies/envisat.toml'\nframe = 'ICRF'\nafter = '1 d'\naccuracy = '1 deg'\n"
                         "[[torque]]\nkind = 'sunlight'\nmesh = '" POLHODE_DATA_DIR
                         "/samples/mesh/box.obj'\nunit_m = 1\nspecular = 0\ndiffuse = 0\norbit = 'sun'\n"
                         "centre_of_mass = 'mesh origin'\n";
  try {
    read_scene(path);
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()),
              path + ":13: torque.orbit: found 'sun', but the scene has no table [orbit.sun]");
  }
  std::filesystem::remove(path);
}

TEST(Scenes, RefuseWhatTheyCannotMean) {
  const std::string path = ::testing::TempDir() + "polhode_scene_test.toml";
  const std::string head =
      "name = 'x'\nsource = 'y'\nbody = '" POLHODE_DATA_DIR "/bodies/apophis.toml'\nframe = 'ICRF'\n";
  const std::string rest = "after = '1 d'\naccuracy = '1 deg'\n";
  const auto complaint = [&](const std::string& text) -> std::string {
    std::ofstream(path) << text;
    try {
      read_scene(path);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no InputError";
  };
  EXPECT_NE(complaint(head + rest + "[[torque]]\nkind = 'constant'\ntorque_n_m = [1, 2, 3]\naxes = 'body'\n")
                .find("ratios only"),
            std::string::npos);
  EXPECT_NE(complaint(head + rest + "[[torque]]\nkind = 'wind'\n").find("allowed: gravity gradient"),
            std::string::npos);
  EXPECT_NE(complaint(head + "accuracy = '1 deg'\n").find("span is empty"), std::string::npos);
  EXPECT_NE(complaint(head + "after = '1 d'\naccuracy = '-1 deg'\n").find("1e-15 rad or more"), std::string::npos);
  EXPECT_NE(complaint(head + rest + "colour = 'red'\n").find("colour"), std::string::npos);
  EXPECT_EQ(complaint(head + rest), "no InputError");
  const std::string gravity = "[[torque]]\nkind = 'gravity gradient'\norbit = 'earth'\n";
  EXPECT_NE(complaint(head + rest + gravity).find("no table [orbit.earth]"), std::string::npos);
  const std::string table = "[orbit.earth]\nmu_m3_s2 = 3.986e14\ntrajectory = '" POLHODE_DATA_DIR
                            "/scenes/trajectories/toutatis-earth.oem'\n";
  EXPECT_NE(complaint(head + rest + table + gravity).find("it covers 1992-07-04T00:00:00 to 2013-01-01T14:00:00 TDB"),
            std::string::npos);
  EXPECT_NE(complaint(head + rest + "[orbit.earth]\nmu_m3_s2 = -1\n").find("positive number"), std::string::npos);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace polhode
