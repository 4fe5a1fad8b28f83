#pragma once

#include <fitsio.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <string_view>

#include "polhode/write/output_file.hpp"

namespace polhode {

/// Ones' complement sum of 32-bit words: the carry comes back in at the low end (FITS 4.0 appendix J).
std::uint64_t fits_sum(std::uint64_t sum);

/// A new FITS file, open. Every call's status passes through check().
class FitsFile {
 public:
  /// `path` is for messages.
  FitsFile(const std::string& file, std::string path);
  FitsFile(const FitsFile&) = delete;
  FitsFile& operator=(const FitsFile&) = delete;
  ~FitsFile();

  fitsfile* handle() { return file_; }

  /// Throws FileError if `status` is a cfitsio error, with the system's reason where there is one.
  void check(int status) const;
  void close();

  /// A text of any length, with CONTINUE cards where one is too short (FITS 4.0, 4.2.1.2). Not by
  /// fits_write_key_longstr, which finds no end where there are many quotes.
  void key(const char* name, const std::string& text, const char* comment);
  void key(const char* name, double value, const char* comment);
  /// LONGSTRN, by which readers know that texts may go on in CONTINUE cards.
  void announce_long_texts();
  void flag(const char* name, bool value, const char* comment);

  /// DATASUM and CHECKSUM of the current HDU. cfitsio's own would read the data again, and note the time of day, so
  /// that no two files were the same.
  void checksums(std::uint64_t data_sum);
  /// To be called before the first data: else cfitsio moves all of them where the two cards need another block.
  void leave_room_for_checksums();
  void comment(const std::string& text);

 private:
  std::string path_;
  fitsfile* file_ = nullptr;
};

/// Puts numbers in file order one after the other, and sums their 32-bit words.
class FitsPacker {
 public:
  explicit FitsPacker(char* to) : at_(to) {}
  void put(double value) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    sum_ += (bits >> 32) + (bits & 0xffffffffU);
    static_assert(std::endian::native == std::endian::little, "FITS is big-endian: bytes are swapped");
    const std::uint64_t swapped = __builtin_bswap64(bits);
    std::memcpy(at_, &swapped, sizeof swapped);
    at_ += sizeof swapped;
  }
  /// A text of whole 32-bit words.
  void put_words(std::string_view text) {
    for (std::size_t i = 0; i < text.size(); ++i) {
      sum_ += std::uint64_t{static_cast<unsigned char>(text[i])} << (24U - 8U * (i % 4));
    }
    std::memcpy(at_, text.data(), text.size());
    at_ += text.size();
  }
  std::uint64_t sum() const { return sum_; }

 private:
  char* at_;
  std::uint64_t sum_ = 0;
};

/// The bytes of a file into an output, packed by gzip if asked for; `progress` gets the part that is done.
void pass_on_file(const std::string& file, bool packed, OutputBytes& out,
                  const std::function<void(double part)>& progress);

}  // namespace polhode
