#include "polhode/read/fits_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "polhode/base/error.hpp"
#include "polhode/base/text.hpp"

namespace polhode {
namespace {

constexpr std::size_t block = 2880;
constexpr std::size_t card = 80;
constexpr std::size_t most_columns = 999;  // FITS 4.0, 7.3.1

/// The bytes that a code of TFORM stands for, bits apart; 0 for a code that is none.
std::size_t code_size(char code) {
  switch (code) {
    case 'L':
    case 'B':
    case 'A':
      return 1;
    case 'I':
      return 2;
    case 'J':
    case 'E':
      return 4;
    case 'K':
    case 'D':
    case 'C':
    case 'P':
      return 8;
    case 'M':
    case 'Q':
      return 16;
    default:
      return 0;
  }
}

/// a times b, or the largest number where it is too large.
std::size_t product(std::size_t a, std::size_t b) {
  return a != 0 && b > std::numeric_limits<std::size_t>::max() / a ? std::numeric_limits<std::size_t>::max() : a * b;
}

template <typename Number, typename Bits>
double big_endian(std::string_view bytes) {
  Bits bits = 0;
  for (const char c : bytes.substr(0, sizeof(Bits))) bits = (bits << 8) | static_cast<unsigned char>(c);
  return static_cast<double>(std::bit_cast<Number>(bits));
}

/// Ones' complement sum of 32-bit words, the last filled up with zeros (FITS 4.0 appendix J), added to another.
std::uint64_t checksum(std::string_view bytes, std::uint64_t sum) {
  for (std::size_t at = 0; at < bytes.size(); at += 4) {
    std::uint32_t word = 0;
    for (std::size_t k = at; k < at + 4; ++k)
      word = (word << 8) | (k < bytes.size() ? static_cast<unsigned char>(bytes[k]) : 0U);
    sum += word;
  }
  while ((sum >> 32) != 0) sum = (sum & 0xffffffffU) + (sum >> 32);
  return sum;
}

}  // namespace

std::optional<std::string> FitsTable::text(const Header& header, std::string_view keyword) {
  const auto found = header.find(keyword);
  if (found == header.end()) return std::nullopt;
  const std::optional<std::string> out = text_of(found->second);
  return out ? std::optional(std::string(trimmed(*out))) : std::nullopt;
}

/// 'The text' that begins a card's value, as it is.
std::optional<std::string> FitsTable::text_of(std::string_view value) {
  value = trimmed(value);
  if (!value.starts_with('\'')) return std::nullopt;
  value.remove_prefix(1);
  std::string out;
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (value[i] == '\'') {
      if (i + 1 == value.size() || value[i + 1] != '\'') break;
      ++i;  // '' is one quote
    }
    out += value[i];
  }
  return out;
}

std::optional<double> FitsTable::number(const Header& header, std::string_view keyword) {
  const auto found = header.find(keyword);
  if (found == header.end()) return std::nullopt;
  std::string value(trimmed(std::string_view(found->second).substr(0, found->second.find('/'))));
  std::replace(value.begin(), value.end(), 'D', 'E');  // 1.0D5
  return parse_number(value);
}

std::size_t FitsTable::count(const Header& header, std::string_view keyword) const {
  const auto found = header.find(keyword);
  if (found == header.end()) throw InputError({file_, 0}, fmt::format("broken FITS: {} is missing", keyword));
  const std::string_view text = trimmed(std::string_view(found->second).substr(0, found->second.find('/')));
  const std::optional<long long> value = parse_integer(text);
  if (!value || *value < 0) {
    throw InputError({file_, 0}, fmt::format("broken FITS: {} = {:.20}, a whole number is wanted", keyword, text));
  }
  return static_cast<std::size_t>(*value);
}

/// Takes the cards as far as END, and the rest of their last block.
FitsTable::Header FitsTable::take_header(std::string_view& rest) const {
  Header header;
  std::string last;  // keyword whose text may go on: FITS 4.0, 4.2.1.2
  for (std::size_t at = 0; at + card <= rest.size(); at += card) {
    const std::string_view line = rest.substr(at, card);
    const std::string_view keyword = trimmed(line.substr(0, 8));
    if (keyword == "END") {
      rest.remove_prefix(std::min(rest.size(), (at / block + 1) * block));
      return header;
    }
    if (line.substr(8, 2) == "= ") {
      last = header.try_emplace(std::string(keyword), line.substr(10)).second ? keyword : "";
    } else if (keyword == "CONTINUE" && !last.empty()) {
      const std::optional<std::string> begin = text_of(header[last]), rest_of_it = text_of(line.substr(10));
      constexpr std::size_t longest = 1U << 16U;
      if (!begin || !begin->ends_with('&') || begin->size() > longest || !rest_of_it) continue;
      std::string whole = "'";
      for (const char c : begin->substr(0, begin->size() - 1) + *rest_of_it) whole.append(c == '\'' ? 2 : 1, c);
      header[last] = whole + "'";
    } else {
      last.clear();
    }
  }
  throw InputError({file_, 0}, "broken FITS: a header without END");
}

/// Equation 2 of FITS 4.0, without the padding.
std::size_t FitsTable::data_size(const Header& header) const {
  const std::size_t axes = count(header, "NAXIS");
  if (axes == 0) return 0;
  if (axes > most_columns) throw InputError({file_, 0}, fmt::format("broken FITS: NAXIS = {}", axes));
  std::size_t size = 1;
  for (std::size_t i = 1; i <= axes; ++i) size = product(size, count(header, fmt::format("NAXIS{}", i)));
  const std::size_t heap = header.contains("PCOUNT") ? count(header, "PCOUNT") : 0;
  const std::size_t groups = header.contains("GCOUNT") ? count(header, "GCOUNT") : 1;
  const double bits = number(header, "BITPIX").value_or(0.0);
  const auto bytes = static_cast<std::size_t>(std::min(std::abs(bits) / 8.0, 8.0));
  if (heap > std::numeric_limits<std::size_t>::max() - size) return std::numeric_limits<std::size_t>::max();
  return product(bytes, product(groups, size + heap));
}

FitsTable::FitsTable(std::string_view bytes, std::string_view extension, std::string file) : file_(std::move(file)) {
  std::string_view rest = bytes;
  while (!rest.empty()) {
    const std::string_view whole = rest;
    header_ = take_header(rest);
    const std::size_t size = data_size(header_);
    const bool wanted =
        text(header_, "XTENSION") == "BINTABLE" && upper_case(text(header_, "EXTNAME").value_or("")) == extension;
    if (!wanted) {
      if (size > rest.size()) break;
      rest.remove_prefix(std::min(rest.size(), product((size + block - 1) / block, block)));
      continue;
    }
    if (header_.contains("ZTABLE")) {
      throw InputError({file_, 0}, fmt::format("the table {} is compressed by tiles; unpack it first", extension));
    }
    row_bytes_ = count(header_, "NAXIS1");
    rows_ = count(header_, "NAXIS2");
    if (count(header_, "NAXIS") != 2 || product(rows_, row_bytes_) > rest.size()) {
      throw InputError({file_, 0}, fmt::format("the file ends within its table {}: {} rows of {} bytes are announced",
                                               extension, rows_, row_bytes_));
    }
    data_ = rest.substr(0, rows_ * row_bytes_);
    check_sums(whole.substr(0, whole.size() - rest.size()), rest.substr(0, size));
    return;
  }
  throw InputError({file_, 0}, fmt::format("the FITS file has no binary table {}", extension));
}

void FitsTable::check_sums(std::string_view header, std::string_view data) {
  const std::uint64_t of_data = checksum(data, 0);
  const std::string stated = text("DATASUM").value_or("");  // '' states none
  if (const auto sum = parse_integer(stated); sum && static_cast<std::uint64_t>(*sum) != of_data) {
    throw InputError({file_, 0},
                     fmt::format("DATASUM is {} and the data give {}: the rows are damaged, or were changed "
                                 "by what leaves the sum as it was",
                                 stated, of_data));
  }
  constexpr std::uint64_t minus_zero = 0xffffffff;
  checksum_is_right_ = text("CHECKSUM").value_or("").empty() || checksum(header, of_data) == minus_zero;
}

std::optional<std::string> FitsTable::text(std::string_view keyword) const { return text(header_, keyword); }

std::optional<double> FitsTable::number(std::string_view keyword) const { return number(header_, keyword); }

std::string FitsTable::unit(std::string_view keyword) const {
  const auto found = header_.find(keyword);
  if (found == header_.end()) return {};
  const std::string_view record(found->second);
  const std::size_t begin = record.find("/ ["), end = record.find(']', begin);
  if (begin == std::string_view::npos || end == std::string_view::npos) return {};
  return std::string(record.substr(begin + 3, end - begin - 3));
}

std::optional<FitsTable::Column> FitsTable::column(std::string_view name, std::size_t width) const {
  const std::size_t columns = count(header_, "TFIELDS");
  if (columns > most_columns) throw InputError({file_, 0}, fmt::format("broken FITS: TFIELDS = {}", columns));
  std::size_t offset = 0;
  for (std::size_t i = 1; i <= columns; ++i) {
    const std::string form = text(header_, fmt::format("TFORM{}", i)).value_or("");
    const std::size_t digits = std::min(form.find_first_not_of("0123456789"), form.size());
    const char code = digits < form.size() ? form[digits] : ' ';
    const std::size_t repeat =
        digits == 0 ? 1 : static_cast<std::size_t>(parse_integer(form.substr(0, digits)).value_or(-1));
    const std::size_t size = code == 'X' ? repeat / 8 + (repeat % 8 != 0 ? 1 : 0) : product(repeat, code_size(code));
    if ((code != 'X' && code_size(code) == 0) || size > row_bytes_ || offset > row_bytes_ - size) {
      throw InputError({file_, 0},
                       fmt::format("broken FITS: TFORM{} = '{:.20}' in rows of {} bytes", i, form, row_bytes_));
    }
    if (upper_case(text(header_, fmt::format("TTYPE{}", i)).value_or("")) != upper_case(name)) {
      offset += size;
      continue;
    }
    if (repeat != width || (code != 'D' && code != 'E')) {
      throw InputError({file_, 0}, fmt::format("column {} is {:.20}; {} real numbers are wanted ({}D or {}E)", name,
                                               form, width, width, width));
    }
    const double scale = number(header_, fmt::format("TSCAL{}", i)).value_or(1.0);
    const double zero = number(header_, fmt::format("TZERO{}", i)).value_or(0.0);
    Column out;
    out.unit = text(header_, fmt::format("TUNIT{}", i)).value_or("");
    out.values.reserve(rows_ * width);
    for (std::size_t row = 0; row < rows_; ++row) {
      for (std::size_t k = 0; k < width; ++k) {
        const std::string_view at = data_.substr(row * row_bytes_ + offset + k * code_size(code));
        const double value = code == 'D' ? big_endian<double, std::uint64_t>(at) : big_endian<float, std::uint32_t>(at);
        out.values.push_back(zero + scale * value);
      }
    }
    return out;
  }
  return std::nullopt;
}

}  // namespace polhode
