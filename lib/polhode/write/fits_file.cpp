#include "polhode/write/fits_file.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <utility>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/write/document.hpp"

namespace polhode {

std::uint64_t fits_sum(std::uint64_t sum) {
  while ((sum >> 32) != 0) sum = (sum & 0xffffffffU) + (sum >> 32);
  return sum;
}

FitsFile::FitsFile(const std::string& file, std::string path) : path_(std::move(path)) {
  if (file.size() >= FLEN_FILENAME) {
    throw FileError(fmt::format("cannot write {}: cfitsio takes paths of less than {} bytes", path_, FLEN_FILENAME));
  }
  errno = 0;
  int status = 0;
  fits_create_diskfile(&file_, file.c_str(), &status);
  check(status);
}

FitsFile::~FitsFile() {
  if (file_ == nullptr) return;
  int status = 0;
  fits_close_file(file_, &status);
  fits_clear_errmsg();
}

void FitsFile::check(int status) const {
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

void FitsFile::close() {
  int status = 0;
  errno = 0;
  fits_close_file(file_, &status);
  file_ = nullptr;
  check(status);
}

void FitsFile::key(const char* name, const std::string& text, const char* comment) {
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

void FitsFile::key(const char* name, double value, const char* comment) {
  int status = 0;
  constexpr int shortest_of_17_digits = -17;
  fits_write_key_dbl(file_, name, value, shortest_of_17_digits, comment, &status);
  check(status);
}

void FitsFile::announce_long_texts() {
  int status = 0;
  fits_write_key_longwarn(file_, &status);
  check(status);
}

void FitsFile::flag(const char* name, bool value, const char* comment) {
  int status = 0;
  fits_write_key_log(file_, name, value ? 1 : 0, comment, &status);
  check(status);
}

void FitsFile::checksums(std::uint64_t data_sum) {
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
  fits_encode_chksum(fits_sum(sum), 1, text);  // 1: its complement, so that the whole HDU sums to minus zero
  fits_modify_key_str(file_, "CHECKSUM", text, "&", &status);
  check(status);
}

void FitsFile::leave_room_for_checksums() {
  int status = 0;
  fits_set_hdrsize(file_, 2, &status);
  check(status);
}

void FitsFile::comment(const std::string& text) {
  int status = 0;
  fits_write_comment(file_, ascii_text(text).c_str(), &status);
  check(status);
}

void pass_on_file(const std::string& file, bool packed, OutputBytes& out,
                  const std::function<void(double part)>& progress) {
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

}  // namespace polhode
