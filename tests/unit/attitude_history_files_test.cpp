// Attitude histories as FITS, tables and gzip in memory: what is read, and what is refused.
#include <gtest/gtest.h>
#include <zlib.h>

#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/ephemeris/attitude_history.hpp"
#include "polhode/ephemeris/resample.hpp"
#include "polhode/read/body.hpp"
#include "polhode/read/text_file.hpp"

namespace polhode {
namespace {

const std::string samples = POLHODE_DATA_DIR "/samples/";

std::string fault_of(const std::string& content) {
  try {
    parse_attitude_history(content, "m");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

// --- FITS in memory --------------------------------------------------------------------------------------------------

/// A FITS file with one table ATTITUDE, by hand.
std::string fits(const std::vector<std::string>& cards, const std::string& data) {
  const auto block = [](std::string text, char fill) {
    text.resize((text.size() + 2879) / 2880 * 2880, fill);
    return text;
  };
  const auto header = [&](const std::vector<std::string>& lines) {
    std::string text;
    for (std::string line : lines) {
      line.resize(80, ' ');
      text += line;
    }
    std::string end = "END";
    end.resize(80, ' ');
    return block(text + end, ' ');
  };
  return header(
             {"SIMPLE  =                    T", "BITPIX  =                    8", "NAXIS   =                    0"}) +
         header(cards) + block(data, '\0');
}

std::string big_endian(std::initializer_list<double> values) {
  std::string bytes;
  for (const double value : values) {
    for (int shift = 56; shift >= 0; shift -= 8)
      bytes += static_cast<char>((std::bit_cast<std::uint64_t>(value) >> shift) & 0xffU);
  }
  return bytes;
}

std::vector<std::string> cards() {
  return {"XTENSION= 'BINTABLE'",
          "BITPIX  = 8",
          "NAXIS   = 2",
          "NAXIS1  = 48 / bytes",
          "NAXIS2  = 2",
          "PCOUNT  = 0",
          "GCOUNT  = 1",
          "TFIELDS = 3",
          "TTYPE1  = 'flags   '",
          "TFORM1  = '64X     '",
          "TTYPE2  = 'Time'",
          "TFORM2  = 'D'",
          "TUNIT2  = 's'",
          "TTYPE3  = 'QPARAM'",
          "TFORM3  = '4D'",
          "EXTNAME = 'ATTITUDE'",
          "OBJECT  = 'O''Brien  '",
          "TIMESYS = 'TT'",
          "MJDREFI =   51544",
          "MJDREFF = 5.0D-1 / noon",
          "REFFRAMA= 'ICRF'"};
}

const std::string two_rows = big_endian({0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 10.0, 0.0, 0.0, 0.6, 0.8});

std::string with_card(const std::string& from, const std::string& to) {
  std::vector<std::string> list = cards();
  for (std::string& card : list) {
    if (card == from) card = to;
  }
  return fits(list, two_rows);
}

TEST(FitsHistory, IsReadFromMemory) {
  const AttitudeHistory h = *parse_attitude_history(fits(cards(), two_rows), "m");
  EXPECT_EQ(h.object, "O'Brien");
  ASSERT_EQ(h.segments.size(), 1U);
  ASSERT_EQ(h.segments[0].samples.size(), 2U);
  EXPECT_EQ(format_date(h.segments[0].samples[1].time, TimeScale::tt, 3), "2000-01-01T12:00:10.000");
  EXPECT_NEAR(h.segments[0].samples[1].q_frame_from_body.z(), 0.6, 1e-15);
  EXPECT_FALSE(h.segments[0].has_rates());

  const AttitudeHistory sample = *read_attitude_history(samples + "attitude/spinner.fits");  // made by astropy
  EXPECT_EQ(sample.object, "SPINNER");
  ASSERT_EQ(sample.rows(), 4U);
  EXPECT_NEAR(sample.segments[0].samples[3].omega_body_rad_s->z(), 0.05, 1e-9);  // a column of floats
  const AttitudeHistory table = *read_attitude_history(samples + "attitude/spinner.ecsv");
  EXPECT_LT(compare(sample, table).largest_rad, 1e-15);
}

TEST(FitsHistory, WhatAHeaderClaimsIsHeldAgainstTheBytes) {
  EXPECT_EQ(fault_of(with_card("NAXIS2  = 2", "NAXIS2  = 4000000000000000000")),
            "m: the file ends within its table ATTITUDE: 4000000000000000000 rows of 48 bytes are announced");
  EXPECT_EQ(fault_of(with_card("NAXIS1  = 48 / bytes", "NAXIS1  = 9223372036854775807")).substr(0, 45),
            "m: the file ends within its table ATTITUDE: 2");
  EXPECT_EQ(fault_of(with_card("NAXIS2  = 2", "NAXIS2  = -2")),
            "m: broken FITS: NAXIS2 = -2, a whole number is wanted");
  EXPECT_EQ(fault_of(with_card("TFORM1  = '64X     '", "TFORM1  = '99999999999999999999X'")),
            "m: broken FITS: TFORM1 = '99999999999999999999' in rows of 48 bytes");
  EXPECT_EQ(fault_of(with_card("TFORM3  = '4D'", "TFORM3  = '5D'")),
            "m: broken FITS: TFORM3 = '5D' in rows of 48 bytes");
  EXPECT_EQ(fault_of(with_card("TFORM3  = '4D'", "TFORM3  = '8E'")),
            "m: column QPARAM is 8E; 4 real numbers are wanted (4D or 4E)");
  EXPECT_EQ(fault_of(with_card("TFIELDS = 3", "TFIELDS = 1000000")), "m: broken FITS: TFIELDS = 1000000");
  EXPECT_EQ(fault_of(with_card("TFIELDS = 3", "TFIELDS = 2")), "m: the table ATTITUDE has no column TIME or QPARAM");
  EXPECT_EQ(fault_of(with_card("EXTNAME = 'ATTITUDE'", "EXTNAME = 'EVENTS'")),
            "m: the FITS file has no binary table ATTITUDE");
  EXPECT_EQ(fault_of(with_card("PCOUNT  = 0", "ZTABLE  = T")),
            "m: the table ATTITUDE is compressed by tiles; unpack it first");
  EXPECT_EQ(fault_of(with_card("TIMESYS = 'TT'", "")), "m: TIMESYS is missing");
  const std::string whole = fits(cards(), two_rows);
  EXPECT_EQ(fault_of(whole.substr(0, 4000)), "m: broken FITS: a header without END");
  EXPECT_EQ(fault_of(whole.substr(0, 5800)).substr(0, 43), "m: the file ends within its table ATTITUDE:");
  EXPECT_EQ(fault_of(whole.substr(0, 5760 + 96)), "accepted");  // without the last padding
  EXPECT_EQ(fault_of(fits(cards(), big_endian({0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1}))),
            "m: row 2: its time is not after the one above");
  EXPECT_EQ(fault_of(fits(cards(), big_endian({0, 0, 0, 0, 0, 2, 0, 1, 0, 0, 0, 1}))),
            "m: row 1: the quaternion has length 2, it must be 1");
}

TEST(FitsHistory, SumsAreHeldAgainstTheBytes) {
  const auto with_card = [](const std::string& card) {
    std::vector<std::string> list = cards();
    list.push_back(card);
    return fits(list, two_rows);
  };
  EXPECT_EQ(fault_of(with_card("DATASUM = '3433929114'")), "accepted");  // by numpy
  EXPECT_EQ(fault_of(with_card("DATASUM = ''")), "accepted");
  EXPECT_EQ(
      fault_of(with_card("DATASUM = '3433929115'")),
      "m: DATASUM is 3433929115 and the data give 3433929114: the rows are damaged, or were changed by what leaves "
      "the sum as it was");
  EXPECT_TRUE(parse_attitude_history(with_card("CHECKSUM= ''"), "m")->warnings.empty());
  EXPECT_EQ(parse_attitude_history(with_card("CHECKSUM= '0000000000000000'"), "m")->warnings.size(), 1U);
}

TEST(TextHistory, AFrameThatIsNotKnownIsANameOnly) {
  const std::string text = read_text_file(samples + "attitude/spinner.ecsv");
  const AttitudeHistory h = *parse_attitude_history(replaced(text, "frame_a: \"ICRF\"", "frame_a: \"LVLH\""), "m");
  EXPECT_EQ(h.segments[0].frame, "LVLH");
  EXPECT_FALSE(h.segments[0].known_frame);
  EXPECT_EQ(h.object, "spinner");
  EXPECT_EQ(h.warnings.size(), 1U);
}

TEST(TextHistory, NoColumnIsPassedOverInSilence) {
  const std::string text = read_text_file(samples + "attitude/spinner.ecsv");
  EXPECT_TRUE(parse_attitude_history(text, "m")->warnings.empty());
  const std::string names = "date_tt,q_x,q_y,q_z,q_scalar,omega_body_x_rad_s,omega_body_y_rad_s,omega_body_z_rad_s";
  const auto with_names = [&](const std::string& from, const std::string& to) {
    return replaced(text, "\n" + names, "\n" + replaced(names, from, to));
  };
  const AttitudeHistory h = *parse_attitude_history(with_names("omega_body_y_rad_s", "wy"), "m");
  EXPECT_FALSE(h.segments[0].has_rates());
  EXPECT_EQ(h.warnings, std::vector<std::string>{"m: not read: omega_body_x_rad_s, wy, omega_body_z_rad_s; rates are "
                                                 "omega_body_x_rad_s, _y_rad_s and _z_rad_s"});
  EXPECT_NE(fault_of(with_names("omega_body_z_rad_s", "q_scalar")).find(": there are two columns q_scalar"),
            std::string::npos);
  EXPECT_NE(fault_of(replaced(text, "{name: q_x, ", "{name: q_x, unit: deg, "))
                .find(": column q_x has the unit deg by the header; none is wanted"),
            std::string::npos);
}

// --- gzip ------------------------------------------------------------------------------------------------------------

std::string packed(const std::string& text) {
  z_stream stream{};
  EXPECT_EQ(deflateInit2(&stream, 9, Z_DEFLATED, 16 + MAX_WBITS, 9, Z_DEFAULT_STRATEGY), Z_OK);
  std::string out(deflateBound(&stream, text.size()) + 64, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

TEST(Gzip, IsUnpackedWithinBounds) {
  const std::string text = read_text_file(samples + "attitude/spinner.fits");
  EXPECT_EQ(unpack_gzip(packed(text), "m"), text);
  EXPECT_EQ(unpack_gzip(packed(text) + packed("more"), "m"), text + "more");
  EXPECT_EQ(unpack_gzip(packed(text) + std::string(512, '\0'), "m"), text);
  const auto fault = [](const std::string& content) -> std::string {
    try {
      unpack_gzip(content, "m");
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  const std::string small = packed(text);
  EXPECT_EQ(fault(small.substr(0, small.size() / 2)), "m: the gzip file is cut off");
  EXPECT_EQ(fault(small + "junk"), "m: something else follows the data that gzip packed");
  EXPECT_EQ(fault("\x1f\x8b\x08 and no more"), "m: the gzip file is broken");
  EXPECT_EQ(fault(packed(std::string(80U << 20U, '\0'))), "m: unpacks to more than a hundred times its size");
}

}  // namespace
}  // namespace polhode
