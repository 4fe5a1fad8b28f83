#include "polhode/write/fits.hpp"

#include <fitsio.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string_view>
#include <utility>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/write/document.hpp"
#include "polhode/write/output_file.hpp"

namespace polhode {
namespace {

/// Ones' complement sum of 32-bit words: the carry comes back in at the low end (FITS 4.0 appendix J).
std::uint64_t fold(std::uint64_t sum) {
  while ((sum >> 32) != 0) sum = (sum & 0xffffffffU) + (sum >> 32);
  return sum;
}

/// A new FITS file, open. Every call's status passes through check().
class Fits {
 public:
  /// `path` is for messages.
  Fits(const std::string& file, std::string path) : path_(std::move(path)) {
    if (file.size() >= FLEN_FILENAME) {
      throw FileError(fmt::format("cannot write {}: cfitsio takes paths of less than {} bytes", path_, FLEN_FILENAME));
    }
    errno = 0;
    int status = 0;
    fits_create_diskfile(&file_, file.c_str(), &status);
    check(status);
  }
  Fits(const Fits&) = delete;
  Fits& operator=(const Fits&) = delete;
  ~Fits() {
    if (file_ == nullptr) return;
    int status = 0;
    fits_close_file(file_, &status);
    fits_clear_errmsg();
  }

  fitsfile* handle() { return file_; }

  /// Throws FileError if `status` is a cfitsio error, with the system's reason where there is one.
  void check(int status) const {
    if (status == 0) return;
    const int system_error = errno;
    char text[FLEN_STATUS] = {};
    fits_get_errstatus(status, text);
    char message[FLEN_ERRMSG] = {};
    fits_read_errmsg(message);
    fits_clear_errmsg();
    const std::string reason = system_error != 0 ? fmt::format("{} ({})", std::strerror(system_error), text)
                               : message[0] != 0 ? fmt::format("{}: {}", text, message)
                                                 : std::string(text);
    throw FileError(fmt::format("cannot write {}: {}", path_, reason));
  }

  void close() {
    int status = 0;
    errno = 0;
    fits_close_file(file_, &status);
    file_ = nullptr;
    check(status);
  }

  /// A text of any length, with CONTINUE cards where one is too short (FITS 4.0, 4.2.1.2). Not by
  /// fits_write_key_longstr, which finds no end where there are many quotes.
  void key(const char* name, const std::string& text, const char* comment) {
    std::vector<std::string> parts(1);  // with quotes doubled, which stay together
    constexpr std::size_t longest = 68;
    const std::string value = ascii_text(text);
    for (const char c : value) {
      const std::string_view put = c == '\'' ? "''" : std::string_view(&c, 1);
      if (parts.back().size() + put.size() >= longest) parts.emplace_back();  // leaves room for &
      parts.back() += put;
    }
    int status = 0;
    if (parts.size() == 1) fits_write_key_str(file_, name, value.c_str(), comment, &status);
    for (std::size_t i = 0; parts.size() > 1 && i < parts.size(); ++i) {
      const bool last = i + 1 == parts.size();
      std::string card = i == 0 ? fmt::format("{:<8}= ", name) : std::string("CONTINUE  ");
      card += fmt::format("'{}{}'", parts[i], last ? "" : "&");
      if (last) card += fmt::format(" / {}", comment);
      fits_write_record(file_, card.substr(0, 80).c_str(), &status);
    }
    check(status);
  }
  void key(const char* name, double value, const char* comment) {
    int status = 0;
    constexpr int shortest_of_17_digits = -17;
    fits_write_key_dbl(file_, name, value, shortest_of_17_digits, comment, &status);
    check(status);
  }
  /// LONGSTRN, by which readers know that texts may go on in CONTINUE cards.
  void announce_long_texts() {
    int status = 0;
    fits_write_key_longwarn(file_, &status);
    check(status);
  }
  void flag(const char* name, bool value, const char* comment) {
    int status = 0;
    fits_write_key_log(file_, name, value ? 1 : 0, comment, &status);
    check(status);
  }

  /// DATASUM and CHECKSUM of the current HDU. cfitsio's own would read the data again, and note the time of day, so
  /// that no two files were the same.
  void checksums(std::uint64_t data_sum) {
    key("CHECKSUM", "0000000000000000", "HDU checksum");
    key("DATASUM", fmt::format("{}", data_sum), "data unit checksum");
    int status = 0;
    char* cards = nullptr;
    int count = 0;
    fits_hdr2str(file_, 0, nullptr, 0, &cards, &count, &status);
    check(status);
    constexpr std::size_t block = 2880;
    std::string header(cards);
    fits_free_memory(cards, &status);
    header.resize((header.size() + block - 1) / block * block, ' ');
    std::uint64_t sum = data_sum;
    for (std::size_t at = 0; at < header.size(); at += 4) {
      for (std::size_t k = 0; k < 4; ++k)
        sum += std::uint64_t{static_cast<unsigned char>(header[at + k])} << (24 - 8 * k);
    }
    char text[17] = {};
    fits_encode_chksum(fold(sum), 1, text);  // 1: its complement, so that the whole HDU sums to minus zero
    fits_modify_key_str(file_, "CHECKSUM", text, "&", &status);
    check(status);
  }

  void comment(const std::string& text) {
    int status = 0;
    fits_write_comment(file_, ascii_text(text).c_str(), &status);
    check(status);
  }

 private:
  std::string path_;
  fitsfile* file_ = nullptr;
};

/// Puts numbers in file order one after the other, and sums their 32-bit words.
class Packer {
 public:
  explicit Packer(char* to) : at_(to) {}
  void put(double value) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    sum_ += (bits >> 32) + (bits & 0xffffffffU);
    static_assert(std::endian::native == std::endian::little, "FITS is big-endian: bytes are swapped");
    const std::uint64_t swapped = __builtin_bswap64(bits);
    std::memcpy(at_, &swapped, sizeof swapped);
    at_ += sizeof swapped;
  }
  std::uint64_t sum() const { return sum_; }

 private:
  char* at_;
  std::uint64_t sum_ = 0;
};

void write_keywords(Fits& fits, const Ephemeris& ephemeris, TimeResolution resolution) {
  const EphemerisDescription& description = ephemeris.description();
  const TimeGrid& times = ephemeris.times();
  const Seconds first = times.time(0, resolution);
  const Seconds last = times.time(times.size() - 1, resolution);
  constexpr int decimals = 9;
  fits.announce_long_texts();
  fits.key("OBJECT", description.object, "body");
  if (!description.object_id.empty()) fits.key("OBJECTID", description.object_id, "designation of the body");
  fits.key("CREATOR", creator(), "program that wrote this file");
  fits.key("DATE", creation_date(), "when written, UTC");
  fits.key("TIMESYS", std::string(name(times.scale())), "time scale of TIME and of DATE-BEG, DATE-END");
  fits.key("MJDREF", times.reference_mjd(), "[d] TIME counts from this MJD, in TIMESYS");
  fits.key("TIMEUNIT", "s", "unit of TIME");
  fits.key("TREFPOS", times.scale() == TimeScale::tdb ? "BARYCENTER" : "GEOCENTER", "where these clocks stand");
  fits.key("DATE-BEG", format_date(times.instant(first), times.scale(), decimals), "first row");
  fits.key("DATE-END", format_date(times.instant(last), times.scale(), decimals), "last row");
  fits.key("TSTART", first.high, "[s] TIME of the first row");
  fits.key("TSTOP", last.high, "[s] TIME of the last row");
  fits.key("QORDER", "XYZS", "order within QPARAM: vector part, scalar last");
  fits.key("QDIR", "A2B", "QPARAM takes components from frame A to frame B");
  fits.key("REFFRAMA", ephemeris.frame_name(), "frame A, to which the attitude refers");
  fits.key("REFFRAMB", description.body_axes.empty() ? "BODY" : description.body_axes,
           "frame B, the axes that the body's file names");
  fits.key("METHOD", description.method, "how the motion was computed");
  if (description.promised_error_rad) {
    fits.key("MAXERR", *description.promised_error_rad, "[rad] promised error of the rows");
  }
  if (!description.error_meaning.empty()) fits.key("ERRORIS", description.error_meaning, "what MAXERR covers");
  if (description.torque_evaluations) {
    fits.key("TORQEVAL", static_cast<double>(*description.torque_evaluations), "torque evaluations that it took");
  }
  if (description.tolerance_rad) {
    fits.key("INTERPOL", description.interpolation, "between rows");
    fits.key("INTERERR", *description.tolerance_rad, "[rad] promised error of INTERPOL everywhere");
  }
  if (const std::optional<Inertia>& inertia = ephemeris.inertia()) {
    for (int k = 0; k < 3; ++k) {
      fits.key(fmt::format("INERTIA{}", k + 1).c_str(), inertia->principal_moments[k],
               inertia->absolute ? "[kg m2] principal moment of inertia" : "principal moment of inertia, one any unit");
    }
    const Eigen::Vector4d q = scalar_first(inertia->q_named_from_principal());
    for (int k = 0; k < 4; ++k) {
      fits.key(fmt::format("QPRINC{}", k).c_str(), q[k], "scalar-first q: v_body = q v_principal q*");
    }
  }
  if (!description.source.empty()) fits.comment("Source of the body: " + description.source);
  for (const std::string& caution : description.cautions) fits.comment("Caution: " + caution + ".");
  if (ephemeris.has_covariance()) {
    fits.comment(
        "COV is the covariance of a small turn of the body about the axes of frame B: xx, xy, xz, yy, yz, zz. SIGMA is "
        "the root of its largest eigenvalue: one sigma of the attitude.");
  }
  fits.comment(
      "QPARAM is passive: a body turned by +90 deg about z of frame A has QPARAM (0, 0, 0.7071, 0.7071) and its x axis "
      "along y of frame A. Its sign is continuous from row to row. OMEGA has components in frame B.");
}

/// FITS has a TIMESYS 'ET', but as a forerunner of TT, which astropy takes it for; astropy cannot read 'GPS'.
void refuse_misread_scale(TimeScale scale) {
  if (scale == TimeScale::et) {
    throw TimeScaleError(
        "readers of FITS take the time scale ET for TT, 1.7 ms from SPICE's; take TDB, which is within 0.1 ms of "
        "SPICE's ET, or UTC, TAI, TT");
  }
  if (scale == TimeScale::gps) {
    throw TimeScaleError(
        "readers of FITS do not know the time scale GPS; take TAI, which is GPS + 19 s, or TDB, UTC, TT");
  }
}

/// All of an ephemeris as a new file.
void write_table(Fits& fits, const Ephemeris& ephemeris, const FitsOptions& options,
                 const std::function<void(std::size_t rows)>& progress) {
  const bool covariance = ephemeris.has_covariance();
  const std::size_t doubles_per_row =
      8 + (options.momentum ? 3 : 0) + (covariance ? 7 : 0) + (options.time_low ? 1 : 0);
  const std::size_t row_bytes = doubles_per_row * sizeof(double);
  int status = 0;
  fits_create_img(fits.handle(), BYTE_IMG, 0, nullptr, &status);
  fits.check(status);
  fits.checksums(0);

  std::vector<std::string> names{"TIME", "QPARAM", "OMEGA"};
  std::vector<std::string> forms{"1D", "4D", "3D"};
  std::vector<std::string> units{"s", "", "rad/s"};
  if (options.momentum) {
    names.push_back("L");
    forms.push_back("3D");
    units.push_back(ephemeris.inertia()->absolute ? "N m s" : "");
  }
  if (covariance) {
    names.insert(names.end(), {"SIGMA", "COV"});
    forms.insert(forms.end(), {"1D", "6D"});
    units.insert(units.end(), {"rad", "rad2"});
  }
  if (options.time_low) {
    names.push_back("TIME_LO");
    forms.push_back("1D");
    units.push_back("s");
  }
  const auto pointers = [](std::vector<std::string>& texts) {
    std::vector<char*> out(texts.size());
    std::transform(texts.begin(), texts.end(), out.begin(), [](std::string& text) { return text.data(); });
    return out;
  };
  // No rows yet: they are appended. A table that knew its length would be filled with zeros when we stop early.
  fits_create_tbl(fits.handle(), BINARY_TBL, 0, static_cast<int>(names.size()), pointers(names).data(),
                  pointers(forms).data(), pointers(units).data(), "ATTITUDE", &status);
  fits.check(status);
  const TimeResolution resolution{options.time_low ? TimeResolution::Kind::two_doubles
                                                   : TimeResolution::Kind::one_double};
  write_keywords(fits, ephemeris, resolution);

  const auto encode = [&](const AttitudeBlock& block, EncodedBlock& out) {
    out.bytes.resize(block.rows * row_bytes);
    Packer packer(out.bytes.data());
    const double* q = block.q_frame_from_named.data();
    const double* omega = block.omega_named_rad_s.data();
    for (std::size_t i = 0; i < block.rows; ++i, q += 4, omega += 3) {
      packer.put(block.time[i].high);
      for (const int k : {1, 2, 3, 0}) packer.put(q[k]);
      for (int k = 0; k < 3; ++k) packer.put(omega[k]);
      if (options.momentum) {
        for (std::size_t k = 0; k < 3; ++k) packer.put(block.momentum_named[3 * i + k]);
      }
      if (covariance) {
        packer.put(block.sigma_rad[i]);
        for (std::size_t k = 0; k < 6; ++k) packer.put(block.covariance_rad2[6 * i + k]);
      }
      if (options.time_low) packer.put(block.time[i].low);
    }
    out.word_sum = packer.sum();
  };
  LONGLONG written = 0;
  std::uint64_t data_sum = 0;
  const auto consume = [&](EncodedBlock& block) {
    errno = 0;
    auto* bytes = reinterpret_cast<unsigned char*>(block.bytes.data());
    fits_write_tblbytes(fits.handle(), written + 1, 1, static_cast<LONGLONG>(block.bytes.size()), bytes, &status);
    fits.check(status);
    data_sum = fold(data_sum + fold(block.word_sum));
    written += static_cast<LONGLONG>(block.rows);
    if (progress) progress(static_cast<std::size_t>(written));
  };
  stream_rows(
      ephemeris, resolution, [&] { return encode; }, consume);

  errno = 0;
  fits_flush_file(fits.handle(), &status);  // notes the count of rows in the header
  fits.check(status);
  fits.checksums(data_sum);
  fits.close();
}

/// The bytes of a file into an output, packed by gzip if asked for; `progress` gets the part that is done.
void pass_on(const std::string& file, bool packed, OutputBytes& out, const std::function<void(double part)>& progress) {
  struct Stream : z_stream {
    Stream() : z_stream{} {}
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;
    ~Stream() { deflateEnd(this); }
  } stream;
  constexpr int gzip = 16 + MAX_WBITS;
  constexpr int usual_memory = 8;
  if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, gzip, usual_memory, Z_DEFAULT_STRATEGY) != Z_OK) {
    throw FileError("cannot pack: no memory");
  }
  std::ifstream in(file, std::ios::binary);
  const auto size = static_cast<double>(std::filesystem::file_size(file));
  std::vector<char> plain(1U << 18U), bytes(1U << 18U);
  double done = 0.0;
  do {
    in.read(plain.data(), static_cast<std::streamsize>(plain.size()));
    const auto count = static_cast<std::size_t>(in.gcount());
    if (!in && !in.eof()) throw FileError("cannot read " + file);
    if (!packed) out.write({plain.data(), count});
    stream.next_in = reinterpret_cast<Bytef*>(plain.data());
    stream.avail_in = static_cast<uInt>(count);
    do {
      stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
      stream.avail_out = static_cast<uInt>(bytes.size());
      if (packed) deflate(&stream, in.eof() ? Z_FINISH : Z_NO_FLUSH);
      out.write({bytes.data(), bytes.size() - stream.avail_out});
    } while (stream.avail_out == 0);
    done += static_cast<double>(count);
    progress(done / size);
  } while (!in.eof());
}

}  // namespace

void write_fits(const std::string& path, const Ephemeris& ephemeris, const FitsOptions& options,
                const Progress& progress) {
  if (options.momentum && !ephemeris.inertia()) throw InputError("the angular momentum needs an inertia");
  refuse_misread_scale(ephemeris.times().scale());
  if (!options.packed && !is_passed_through(path)) {
    OutputFile output(path);
    Fits fits(output.temporary_path(), path);
    output.keep_mode();
    write_table(fits, ephemeris, options, progress);
    output.commit();
    return;
  }
  // The sums in a header are known after the rows: the whole file first, beside where it goes.
  OutputBytes output(path);
  const HiddenFile plain(output.scratch_folder());
  {
    Fits fits(plain.path(), path);
    ::chmod(plain.path().c_str(), S_IRUSR | S_IWUSR);  // of nobody's business
    write_table(fits, ephemeris, options, {});
  }
  const auto rows = static_cast<double>(ephemeris.times().size());
  pass_on(plain.path(), options.packed, output, [&](double part) {
    if (progress) progress(static_cast<std::size_t>(part * rows));
  });
  output.commit();
}

}  // namespace polhode
