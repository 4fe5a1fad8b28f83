// Tables of text and their ECSV headers, as astropy and others write them.
#include "polhode/read/text_table.hpp"

#include <gtest/gtest.h>

namespace polhode {
namespace {

std::vector<std::string> cells(std::string_view line, bool comma) {
  std::vector<std::string> list{"of", "the", "line", "above"};
  split_cells(line, comma, list);
  return list;
}

TEST(TextTable, SplitsCells) {
  using List = std::vector<std::string>;
  EXPECT_EQ(cells(" a, b ,,c ", true), (List{"a", "b", "", "c"}));
  EXPECT_EQ(cells("a,", true), (List{"a", ""}));
  EXPECT_EQ(cells("", true), (List{""}));
  EXPECT_EQ(cells("", false), List{});
  EXPECT_EQ(cells("a \t b", false), (List{"a", "b"}));
  EXPECT_EQ(cells(R"("a, b","say ""c""",d)", true), (List{"a, b", "say \"c\"", "d"}));
  EXPECT_EQ(cells(R"("a b" c)", false), (List{"a b", "c"}));
  EXPECT_EQ(cells("\"never closed,b", true), (List{"\"never closed", "b"}));
}

TEST(TextTable, ReadsTheHeaderOfEcsv) {
  TextTable table(
      "# %ECSV 1.0\n# - {name: 'time of', datatype: string}\n# - {name: x, unit: km / s, datatype: float64}\n"
      "# meta: !!omap\n# - {frame_a: \"a \\\"b\\\", {c}\"}\n# - __serialized_columns__:\n#     time of:\n"
      "#       __class__: astropy.time.core.Time\n#       format: isot\n#       scale: tdb\n"
      "#       value: !astropy.table.SerializedColumn {name: 'time of'}\n\"time of\" x\n\n# a comment\n2000-01-01 "
      "1.5\n2 3 4\n",
      "m");
  EXPECT_EQ(table.names(), (std::vector<std::string>{"time of", "x"}));
  EXPECT_EQ(table.header().unit("x"), "km / s");
  EXPECT_EQ(table.header().unit("time of"), "");
  EXPECT_EQ(table.header().entry("frame_a"), "a \"b\", {c}");
  EXPECT_EQ(table.header().scale(), "tdb");
  EXPECT_EQ(table.header().time().name, "time of");
  EXPECT_EQ(table.header().time().value, "time of");
  EXPECT_EQ(table.header().time().format, "isot");
  ASSERT_TRUE(table.next());
  EXPECT_EQ(table.cell(0), "2000-01-01");
  EXPECT_EQ(table.number(1), 1.5);
  EXPECT_EQ(table.here().line, 15U);
  EXPECT_THROW(table.number(0), InputError);
  EXPECT_THROW(table.next(), InputError);
  EXPECT_FALSE(table.next());
  EXPECT_TRUE(TextTable("# nothing\n", "m").names().empty());
}

TEST(TextTable, RefusesDoubledColumnsAndOtherUnits) {
  const TextTable table("# - {name: mjd_tdb, unit: h, datatype: float64}\nmjd_tdb,q_x,q_x\n1,2,3\n", "m");
  const auto fault = [](const auto& work) -> std::string {
    try {
      work();
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(fault([&] { table.column("q_x"); }), "m:2: there are two columns q_x");
  EXPECT_EQ(table.column("q_y"), 3U);
  EXPECT_EQ(fault([&] { table.check_unit(0, "d"); }), "m:2: column mjd_tdb has the unit h by the header; d is wanted");
  EXPECT_EQ(fault([&] { table.check_unit(0, "d h"); }), "accepted");
  EXPECT_EQ(fault([&] { table.check_unit(1, ""); }), "accepted");
}

}  // namespace
}  // namespace polhode
