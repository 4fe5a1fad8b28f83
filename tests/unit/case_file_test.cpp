#include "polhode/read/case_file.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "polhode/base/error.hpp"
#include "polhode/base/located.hpp"

namespace polhode {
namespace {

TEST(InputErrors, TakeThePlaceThatIsNearestToTheFault) {
  const auto fault = [](const char* file, const InputError& problem) {
    try {
      located({"scene.toml", 7}, [&] { located({file, 3}, [&] { throw problem; }); });
    } catch (const InputError& error) {
      return error;
    }
    return InputError("none");
  };
  const InputError unplaced = fault("body.toml", InputError("is wrong")),
                   placed = fault("body.toml", {{"a.obj", 9}, "is wrong"});
  EXPECT_STREQ(unplaced.what(), "body.toml:3: is wrong");
  EXPECT_EQ(unplaced.where().file, "body.toml");
  EXPECT_EQ(unplaced.where().line, 3U);
  EXPECT_EQ(unplaced.message(), "is wrong");
  EXPECT_STREQ(placed.what(), "a.obj:9: is wrong");
  EXPECT_TRUE(InputError("is wrong").where().file.empty());
}

/// A file in the temporary folder that goes with its test.
class CaseFileTest : public ::testing::Test {
 protected:
  std::string file(const std::string& text) const {
    std::ofstream(path_, std::ios::binary) << text;
    return path_;
  }
  /// What the reader says to this text.
  std::string complaint(const std::string& text) const {
    try {
      read_case_file(file(text));
    } catch (const InputError& error) {
      return error.what();
    }
    return "no InputError";
  }
  void TearDown() override { std::filesystem::remove(path_); }

  std::string path_ =
      ::testing::TempDir() + "polhode_" + ::testing::UnitTest::GetInstance()->current_test_info()->name() + ".case";
};

TEST_F(CaseFileTest, ReadsDecimalAndHexadecimalNumbersCommentsAndBlankLines) {
  const CaseFile c = read_case_file(
      file("# a body\n\nI 1 +2.5 0x1.8p+1 # moments\r\n  q\t1e0 -0x1p-1 0 -.5\nm -1 2E3 4.9e-324\nt 0\nt -0x1p40"));
  EXPECT_EQ(c.body.principal_moments, Vector3(1, 2.5, 3));
  EXPECT_EQ(scalar_first(c.body.q_inertial_from_body), Eigen::Vector4d(1, -0.5, 0, -0.5));
  EXPECT_EQ(c.body.momentum_body, Vector3(-1, 2000, 4.9e-324));
  EXPECT_EQ(c.times_s, (std::vector<double>{0.0, -0x1p40}));
}

TEST_F(CaseFileTest, ReadsEveryFileOfTheReferenceCorpus) {
  int read = 0;
  for (const auto& entry : std::filesystem::directory_iterator(POLHODE_DATA_DIR "/truth/dev")) {
    if (entry.path().extension() != ".case") continue;
    EXPECT_FALSE(read_case_file(entry.path()).times_s.empty()) << entry.path();
    ++read;
  }
  EXPECT_GE(read, 50);
}

TEST_F(CaseFileTest, RefusesWrongInputWithFileAndLineAndWhatIsAllowed) {
  const std::string I = "I 1 2 3\n", q = "q 1 0 0 0\n", m = "m 1 2 3\n", t = "t 0\n";
  struct {
    std::string text, line, found;
  } const faults[] = {
      {I + q + m + "t zero\n", ":4: ", "'zero', a number"},
      {I + q + m + "t 1x\n", ":4: ", "'1x', a number"},
      {I + q + m + "t --1\n", ":4: ", "'--1', a number"},
      {I + q + m + "t 0x\n", ":4: ", "'0x', a number"},
      {I + q + m + "t nan\n", ":4: ", "'nan', a finite number"},
      {I + q + m + "t -inf\n", ":4: ", "'-inf', a finite number"},
      {I + q + m + "t 1e400\n", ":4: ", "'1e400', a finite number"},
      {I + q + m + "t\n", ":4: ", "0 value(s) after 't', 1 wanted"},
      {I + q + m + "t 1 2\n", ":4: ", "2 value(s) after 't', 1 wanted"},
      {"I 1 2\n", ":1: ", "2 value(s) after 'I', 3 wanted"},
      {"\nI 1 3 2\n", ":2: ", "ascending"},
      {"I 0 1 2\n", ":1: ", "positive"},
      {"I -1 1 2\n", ":1: ", "positive"},
      {I + "q 0 0 -0 0\n", ":2: ", "0 0 0 0"},
      {I + "q 1 0 0\n", ":2: ", "3 value(s) after 'q', 4 wanted"},
      {I + I, ":2: ", "second 'I'"},
      {I + q + q, ":3: ", "second 'q'"},
      {I + q + m + m, ":4: ", "second 'm'"},
      {I + q + m + "w 1\n", ":4: ", "unknown key 'w'"},
      {I + q + m + "T\n", ":4: ", "a torque is wanted"},
      {I + q + m + "T body 1 2 3\n", ":4: ", "unknown torque 'body', allowed are gravity-gradient"},
      {I + q + m + "T constant-body 1 2\n", ":4: ", "2 value(s) after 'constant-body', 3 wanted"},
      {I + q + m + "T linear-body 1 2 x\n", ":4: ", "'x', a number"},
      {I + q + m + "T gravity-gradient 1 1 -1 0 1 0 0 0 0 1\n", ":4: ", "eccentricity is -1"},
      {I + q + m + "T gravity-gradient 1 0 1 0 1 0 0 0 0 1\n", ":4: ", "periapsis distance is 0"},
      {I + q + m + "T gravity-gradient 1 1 1 0 1 0 0 1 0 0\n", ":4: ", "from a right angle"},
      {q + m + t, ": ", "no 'I' line"},
      {I + m + t, ": ", "no 'q' line"},
      {I + q + t, ": ", "no 'm' line"},
      {I + q + m, ": ", "no 't' line"},
      {"", ": ", "empty"},
      {"# only a comment\n", ": ", "no 'I' line"},
      {std::string("I\0 1 2 3\n", 9), ":1: ", "unknown key"},
  };
  for (const auto& fault : faults) {
    const std::string said = complaint(fault.text);
    EXPECT_EQ(said.rfind(path_ + fault.line, 0), 0U) << said;
    EXPECT_NE(said.find(fault.found), std::string::npos) << "wanted: " << fault.found << "\nsaid: " << said;
  }
}

TEST_F(CaseFileTest, TellsADirectoryFromAMissingFile) {
  EXPECT_THROW(read_case_file(::testing::TempDir()), InputError);
  EXPECT_THROW(read_case_file(path_), FileError);
}

}  // namespace
}  // namespace polhode
