// Body files: the bodies of data/bodies as published, every way of saying the same thing, and every refusal.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <string>

#include "polhode/base/error.hpp"
#include "polhode/motion/free_body.hpp"
#include "polhode/read/body.hpp"
#include "polhode/read/body_file.hpp"

namespace polhode {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();
constexpr double degree = std::numbers::pi / 180.0;

std::string shipped(const char* name) { return std::string(POLHODE_DATA_DIR) + "/bodies/" + name; }

Body parse(const std::string& text) { return parse_body_file(text, "test.toml"); }

constexpr const char* inertia_text = "[inertia]\nmoments = [2, 3, 4]\nunit = 'kg m2'\n";
constexpr const char* state_text = "[state]\nepoch = '2000-01-01T12:00:00 TT'\nframe = 'ICRF'\n";

TEST(BodyFile, ToutatisAsPublished) {
  const Body body = read_body(shipped("toutatis.toml"));
  EXPECT_EQ(body.name, "4179 Toutatis");
  ASSERT_TRUE(body.inertia && body.state && body.state->q_frame_from_named && body.state->omega_named_rad_s);
  EXPECT_FALSE(body.inertia->absolute);
  EXPECT_EQ(body.inertia->principal_moments, Vector3(1.0, 3.0836, 3.235));
  EXPECT_EQ(format_date(body.state->epoch, TimeScale::utc, 3), "1992-11-09T17:49:47.000");
  EXPECT_EQ(body.state->frame, Frame::ecliptic_j2000);
  const Vector3 z = *body.state->q_frame_from_named * Vector3::UnitZ();
  EXPECT_NEAR(std::acos(z.z()) / degree, 65.865, 1e-12);
  EXPECT_NEAR(std::atan2(z.x(), -z.y()) / degree, 145.498, 1e-12);
  EXPECT_NEAR((*body.state->omega_named_rad_s)[2], -98.709 * degree / 86400.0, 1e-20);
}

TEST(BodyFile, EveryShippedBodyCanMove) {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(std::string(POLHODE_DATA_DIR) + "/bodies")) {
    if (entry.path().extension() != ".toml") continue;
    const Body body = read_body(entry.path().string());
    EXPECT_FALSE(body.source.empty()) << entry.path();
    EXPECT_TRUE(body.warnings.empty()) << entry.path();
    const FreeBody free = free_body(body);
    EXPECT_GT(free.momentum_body.norm(), 0.0) << entry.path();
    ++count;
  }
  EXPECT_GE(count, 4U);
}

TEST(BodyFile, AnglesInDegreesUnderRadiansAreWarnedOf) {
  const auto warnings = [](const std::string& angles, const std::string& unit) {
    const std::string text = std::string("name = 'a'\n") + inertia_text + state_text + "[state.attitude]\n" +
                             "sequence = 'ZXZ'\nunit = '" + unit + "'\neuler_angles = " + angles + "\n";
    return parse(text).warnings;
  };
  ASSERT_EQ(warnings("[52, 65, 323]", "rad").size(), 1U);
  EXPECT_NE(warnings("[52, 65, 323]", "rad")[0].find("test.toml:11: euler_angles has 323"), std::string::npos)
      << warnings("[52, 65, 323]", "rad")[0];
  EXPECT_TRUE(warnings("[6.283, 1.5, -6.283]", "rad").empty());
  EXPECT_TRUE(warnings("[52, 65, 323]", "deg").empty());
  const Body spun = parse(
      "name = 'a'\n[spin]\nepoch = '2000-01-01 TT'\nframe = 'ICRF'\nunit = 'rad'\nlambda = 323.0\nbeta = 1.0\n"
      "phi0 = 0.5\nperiod_unit = 'h'\nperiod = 5.0\n");
  ASSERT_FALSE(spun.warnings.empty());
  EXPECT_NE(spun.warnings[0].find("test.toml:6: lambda has 323"), std::string::npos) << spun.warnings[0];
}

TEST(BodyFile, OneAttitudeInFiveNotations) {
  // +90 deg about the frame's z: the body's x axis points along the frame's y.
  for (const char* attitude :
       {"q_frame_from_body_scalar_first = [1, 0, 0, 1]", "q_frame_from_body_scalar_last = [0, 0, 2.0, 2]",
        "q_body_from_frame_scalar_first = [1, 0, 0, -1]", "q_body_from_frame_scalar_last = [0, 0, -1, 1]",
        "euler_angles = [90, 0, 0]\nsequence = 'ZXZ'\nunit = 'deg'"}) {
    const Body body = parse(std::string("name = 'a'\n") + state_text + "[state.attitude]\n" + attitude);
    EXPECT_LT((*body.state->q_frame_from_named * Vector3::UnitX() - Vector3::UnitY()).norm(), 3 * eps) << attitude;
  }
}

TEST(BodyFile, OneRateInManyNotations) {
  const std::string head = std::string("name = 'a'\n") + inertia_text + state_text +
                           "[state.attitude]\nq_frame_from_body_scalar_first = [1, 0, 0, 1]\n";
  const Vector3 want(0.0, -0.1, 0.0);  // body y is the frame's -x
  const double deg = 0.1 / degree;
  const auto entry = [](const char* table, const std::string& components, const char* axes, const char* unit) {
    return std::string("[state.") + table + "]\ncomponents = " + components + "\naxes = '" + axes + "'\nunit = '" +
           unit + "'\n";
  };
  for (const std::string& rate : {entry("angular_velocity", "[0, -0.1, 0]", "body", "rad/s"),
                                  entry("angular_velocity", "[0.1, 0, 0]", "frame", "rad/s"),
                                  entry("angular_velocity", "[0, " + std::to_string(-deg) + ", 0]", "body", "deg/s"),
                                  entry("angular_velocity", "[0, -8640.0, 0]", "body", "rad/day"),
                                  entry("angular_velocity", "[0, -0.954929658551372, 0]", "body", "rpm"),
                                  entry("angular_momentum", "[0, -0.3, 0]", "body", "kg m2/s"),
                                  entry("angular_momentum", "[0, -3e6, 0]", "body", "g cm2/s"),
                                  entry("angular_momentum", "[0.3, 0, 0]", "frame", "N m s")}) {
    const Body body = parse(head + rate);
    EXPECT_LT((*body.state->omega_named_rad_s - want).norm(), 1e-8) << rate;
  }
}

TEST(BodyFile, OneTensorInThreeNotations) {
  const Body a = parse(
      "name='a'\n[inertia]\nmoments=[2,3,4]\nproducts=[0.1,-0.2,0.3]\nproducts_are='tensor elements'\n"
      "unit='kg m2'");
  const Body b = parse(
      "name='a'\n[inertia]\nmoments=[2,3,4]\nproducts=[-0.1,0.2,-0.3]\n"
      "products_are='positive integrals'\nunit='kg m2'");
  const Body c = parse("name='a'\n[inertia]\ntensor=[[2e7,1e6,-2e6],[1e6,3e7,3e6],[-2e6,3e6,4e7]]\nunit='g cm2'");
  EXPECT_EQ(a.inertia->principal_moments, b.inertia->principal_moments);
  EXPECT_EQ(a.inertia->named_from_principal, b.inertia->named_from_principal);
  EXPECT_LT((a.inertia->principal_moments - c.inertia->principal_moments).norm(), 1e-14);
  EXPECT_TRUE(a.inertia->absolute);
}

struct Refusal {
  const char* what;
  std::string text;
  std::size_t line;
  const char* says;  // part of the message
};

TEST(BodyFile, WhatIsWrongIsSaidWithItsLine) {
  const std::string name = "name = 'a'\n";
  const std::string state = name + state_text;  // 4 lines
  const std::string attitude = state + "[state.attitude]\n";
  const std::string rate = state + "[state.angular_velocity]\n";
  const std::string momentum = name + inertia_text + state_text + "[state.angular_momentum]\n";
  const std::vector<Refusal> refusals = {
      {"no TOML", "name = 'a'\nI 1 2 3\n", 2, "not valid TOML"},
      {"key twice", "name = 'a'\nname = 'b'\n", 2, "not valid TOML"},
      {"no name", inertia_text, 1, "name: this key is missing"},
      {"name is a number", "name = 3\n", 1, "found the number 3, text in quotes is wanted"},
      {"unknown key", name + "colour = 'red'\n", 2,
       "colour: unknown key; allowed here: name, id, source, period_uncertainty, "},
      {"unknown key below", name + "[inertia]\nmoments=[1,2,3]\nunits='kg m2'\n", 4, "inertia.units: unknown key"},
      {"inertia is no table", name + "inertia = [1,2,3]\n", 2, "found a list of 3, a table is wanted"},
      {"no inertia in inertia", name + "[inertia]\nunit='kg m2'\n", 2, "moments, tensor"},
      {"both", name + "[inertia]\nmoments=[1,2,3]\ntensor=[[1,0,0],[0,1,0],[0,0,1]]\nunit='kg m2'\n", 4,
       "cannot stand beside moments"},
      {"no unit", name + "[inertia]\nmoments=[1,2,3]\n", 2, "inertia.unit: this key is missing"},
      {"wrong unit", name + "[inertia]\nmoments=[1,2,3]\nunit='kg'\n", 4, "'kg' is not a unit of inertia; allowed: kg"},
      {"text for a number", name + "[inertia]\nmoments=[1,\n2,\n'3']\nunit='kg m2'\n", 5, "found the text '3'"},
      {"two moments", name + "[inertia]\nmoments=[1,2]\nunit='kg m2'\n", 3, "found a list of 2, a list of 3 numbers"},
      {"NaN", name + "[inertia]\nmoments=[1,2,nan]\nunit='kg m2'\n", 3, "found the number nan, a finite number"},
      {"infinite", name + "[inertia]\nmoments=[1,2,inf]\nunit='kg m2'\n", 3, "found the number inf"},
      {"negative", name + "[inertia]\nmoments=[1,-2,3]\nunit='kg m2'\n", 3, "all must be positive"},
      {"triangle", name + "[inertia]\nmoments=[1,5,3]\nunit='ratios'\n", 3, "exceed the sum of the other two"},
      {"unordered", name + "[inertia]\nmoments=[3,4,5]\nunit='ratios'\nlong_axis='z'\n", 5,
       "the moment about z is 5, but the smallest of the three is 3"},
      {"no such axis", name + "[inertia]\nmoments=[3,4,5]\nunit='ratios'\nlong_axis='long'\n", 5, "allowed: x, y, z"},
      {"named axes of a tensor", name + "[inertia]\nunit='ratios'\nlong_axis='x'\ntensor=[[1,0,0],[0,1,0],[0,0,1]]\n",
       4, "only axes without products"},
      {"products without sign", name + "[inertia]\nmoments=[3,4,5]\nproducts=[0,0,1]\nunit='kg m2'\n", 2,
       "products_are: this key is missing"},
      {"unknown sign", name + "[inertia]\nmoments=[3,4,5]\nproducts=[0,0,1]\nproducts_are='-'\nunit='kg m2'\n", 5,
       "allowed: 'tensor elements'"},
      {"sign without products", name + "[inertia]\nmoments=[3,4,5]\nproducts_are='-'\nunit='kg m2'\n", 4, "goes with"},
      {"askew tensor", name + "[inertia]\ntensor=[[1,0.1,0],[0,1,0],[0,0,1]]\nunit='kg m2'\n", 3, "not symmetric"},
      {"short tensor", name + "[inertia]\ntensor=[[1,0],[0,1]]\nunit='kg m2'\n", 3, "three rows of three numbers"},
      {"NaN in tensor", name + "[inertia]\ntensor=[[1,0,0],\n[0,nan,0],[0,0,1]]\nunit='kg m2'\n", 4, "number nan"},
      {"no epoch", name + "[state]\nframe='ICRF'\n", 2, "state.epoch: this key is missing"},
      {"no scale", name + "[state]\nepoch='2000-01-01'\nframe='ICRF'\n", 3, "needs its time scale"},
      {"no date", name + "[state]\nepoch='2000-02-30 TT'\nframe='ICRF'\n", 3, "no such date"},
      {"bare date", name + "[state]\nepoch=2000-01-01T12:00:00\nframe='ICRF'\n", 3, "date or time without quotes"},
      {"no frame", name + "[state]\nepoch='2000-01-01 TT'\n", 2, "state.frame: this key is missing"},
      {"unknown frame", name + "[state]\nepoch='2000-01-01 TT'\nframe='B1950'\n", 4, "allowed: ICRF"},
      {"turning frame", name + "[state]\nepoch='2000-01-01 TT'\nframe='ITRF'\n", 4,
       "'ITRF' is not a frame for a state; allowed: ICRF"},
      {"empty attitude", attitude, 5, "one of these keys is needed"},
      {"zero quaternion", attitude + "q_frame_from_body_scalar_first=[0,0,0,0]\n", 6, "zero quaternion"},
      {"three numbers", attitude + "q_frame_from_body_scalar_last=[0,0,1]\n", 6, "a list of 4 numbers"},
      {"bare quaternion", attitude + "quaternion=[0,0,0,1]\n", 6, "unknown key; allowed here: euler_angles"},
      {"no sequence", attitude + "euler_angles=[1,2,3]\nunit='deg'\n", 5, "sequence: this key is missing"},
      {"bad sequence", attitude + "euler_angles=[1,2,3]\nunit='deg'\nsequence='ZZX'\n", 8, "not an Euler sequence"},
      {"bad angle unit", attitude + "euler_angles=[1,2,3]\nunit='h'\nsequence='ZXZ'\n", 7, "allowed: deg, rad"},
      {"unit of a quaternion", attitude + "q_frame_from_body_scalar_last=[0,0,0,1]\nunit='deg'\n", 7, "goes with"},
      {"no rate unit", rate + "components=[1,2,3]\naxes='body'\n", 5, "unit: this key is missing"},
      {"bad rate unit", rate + "components=[1,2,3]\naxes='body'\nunit='Hz'\n", 8, "allowed: rad/s"},
      {"no axes", rate + "components=[1,2,3]\nunit='rpm'\n", 5, "axes: this key is missing"},
      {"bad axes", rate + "components=[1,2,3]\naxes='inertial'\nunit='rpm'\n", 7, "allowed: 'body'"},
      {"frame axes without attitude", rate + "components=[1,2,3]\naxes='frame'\nunit='rpm'\n", 7, "need an attitude"},
      {"velocity and momentum", rate + "components=[1,2,3]\naxes='body'\nunit='rpm'\n[state.angular_momentum]\n", 9,
       "cannot stand beside angular_velocity"},
      {"momentum in ratios", momentum + "components=[1,2,3]\naxes='body'\nunit='ratios/s'\n", 11, "both must be"},
      {"momentum unit", momentum + "components=[1,2,3]\naxes='body'\nunit='kg m2'\n", 11, "allowed: N m s"},
      {"moments too large", name + "[inertia]\nmoments=[3e60,4e60,5e60]\nunit='kg m2'\n", 2, "from 1e-50 to 1e+50"},
      {"moments too small", name + "[inertia]\nmoments=[5e-324,4,4]\nunit='ratios'\n", 2, "from 1e-50 to 1e+50"},
      {"rate too large", rate + "components=[1e300,0,0]\naxes='body'\nunit='rad/s'\n", 2, "1e-50 to 1e+50 rad/s"},
      {"rate too small", rate + "components=[0,1e-60,0]\naxes='body'\nunit='rad/s'\n", 2, "1e-50 to 1e+50 rad/s"},
      {"momentum that overflows", momentum + "components=[1e308,0,0]\naxes='body'\nunit='N m s'\n", 5, "1e+50 rad/s"},
      {"momentum alone", state + "[state.angular_momentum]\ncomponents=[1,2,3]\naxes='body'\nunit='N m s'\n", 6,
       "needs an [inertia] table"},
  };
  for (const Refusal& refusal : refusals) {
    try {
      parse(refusal.text);
      ADD_FAILURE() << refusal.what << ": accepted";
    } catch (const InputError& error) {
      const std::string message = error.what();
      EXPECT_EQ(message.find("test.toml:" + std::to_string(refusal.line) + ": "), 0U)
          << refusal.what << ": " << message;
      EXPECT_NE(message.find(refusal.says), std::string::npos) << refusal.what << ": " << message;
    }
  }
}

TEST(BodyFile, NamesMayHoldEveryCharacter) {
  const std::string letters = "\uFDFA\uFE0F";
  EXPECT_EQ(parse("name = '" + letters + "'  # " + letters + "\n# " + letters).name, letters);
  EXPECT_EQ(parse("name = \"\"\"a\"\" " + letters + " \\\n  b\\\"" + letters + "\"\"\"\"\"\n").name,
            "a\"\" " + letters + " b\"" + letters + "\"\"");
}

TEST(BodyFile, CharactersOutOfPlaceAreRefused) {
  for (const std::string text :
       {"[\x01]", "x = 1.(\"\"\"\u0329\"\"\"", "x = 0.0\u01F0", "x = [1, -0.0\u00E9]", "x = 1\u3042", "x = 1\u2C7F",
        "\uFDFA=1", "[\uFB26]", "name=\uFEFE'a'", "name='a'\uFB26", "name='''a'''\uFB26",
        "name=\"\"\"a\"\"\"\"\"\uFB26", "name=\"\"\"\\\uFE0F\"\"\"", "name=\"\"\"\\ \t\n \uFE0F\"\"\"",
        "name=\"\\\"\" \uFB26"}) {
    try {
      parse("# \uFDFA '''\n" + text);
      ADD_FAILURE() << text << ": accepted";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("not valid TOML: "), std::string::npos) << text << ": " << error.what();
    }
  }
}

TEST(BodyFile, NumbersOutOfRangeAreRefusedInEveryFormat) {
  const auto mesh = [](const std::string& size) {
    return [size](const std::string&) {
      return "v 0 0 0\nv " + size + " 0 0\nv 0 " + size + " 0\nv 0 0 " + size +
             "\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    };
  };
  EXPECT_TRUE(read_body("a.obj", mesh("1e20")).inertia);
  EXPECT_THROW(read_body("a.obj", mesh("1e30")), InputError);
  EXPECT_THROW(read_body("a.obj", mesh("1e-30")), InputError);
}

TEST(BodyFile, LongQuaternionsAndDoubtfulDatesAreWarnedOf) {
  EXPECT_EQ(parse(std::string("name='a'\n") + state_text + "[state.attitude]\nq_frame_from_body_scalar_first=[1,0,0,1]")
                .warnings.size(),
            1U);
  EXPECT_EQ(parse("name='a'\n[state]\nepoch='2093-01-01 UTC'\nframe='ICRF'\n").warnings.size(), 1U);
}

TEST(BodyFile, FilesThatAreNone) {
  EXPECT_THROW(read_body(shipped("")), InputError);
  EXPECT_THROW(read_body(shipped("no-such-file.toml")), FileError);
}

}  // namespace
}  // namespace polhode
