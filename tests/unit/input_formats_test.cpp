// Every format that is read has samples, and stands in the manual's list.
#include "polhode/read/input_formats.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

const std::filesystem::path data = POLHODE_DATA_DIR;

TEST(InputFormats, EachRecognisesSamplesOfItsFolder) {
  std::map<std::string_view, int> samples;
  for (const InputFormat& format : input_formats()) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(data / format.samples)) {
      if (!entry.is_regular_file()) continue;
      const InputFormat* found = input_format_of(read_text_file(entry.path()));
      if (found != nullptr && found->name == format.name) ++samples[format.name];
    }
    EXPECT_GT(samples[format.name], 0) << format.name;
  }
}

TEST(InputFormats, HistoriesAreReadFromThoseThatSaySo) {
  std::map<std::string_view, int> histories;
  for (const InputFormat& format : input_formats()) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(data / format.samples)) {
      const std::string path = entry.path();
      if (!entry.is_regular_file() || format.name == "scenes (TOML)") continue;
      try {
        const std::string text = read_text_file(path);
        if (format.recognises(text) && format.read(text, RowOfFile(path), read_text_file).history)
          ++histories[format.name];
      } catch (const InputError&) {  // samples of what is refused
      }
    }
    EXPECT_EQ(histories[format.name] > 0, !format.histories.empty()) << format.name;
  }
}

TEST(InputFormats, TheManualListsThem) {
  const std::string page = read_text_file(data.parent_path() / "tools/manual/index.md");
  for (const InputFormat& format : input_formats()) {
    std::string row = "| " + std::string(format.name) + " | ";
    row += format.histories.empty() ? "–" : format.histories;
    EXPECT_NE(page.find(row + " |"), std::string::npos) << row;
  }
}

}  // namespace
}  // namespace polhode
