#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace polhode {

/// A binary table of a FITS file in memory (FITS 4.0 sections 4 and 7.3). A reader of our own: cfitsio trusts the sizes
/// that a header states, and takes a file's name for a program of its own. Here nothing is allocated or read for a size
/// that the bytes do not have.
class FitsTable {
 public:
  /// The first binary table whose EXTNAME is `extension`. `bytes` must outlive it, `file` stands in messages. Throws
  /// InputError if there is no such table, a header before it or its own is broken, or DATASUM is not that of its data.
  FitsTable(std::string_view bytes, std::string_view extension, std::string file);

  std::size_t rows() const { return rows_; }
  /// Whether CHECKSUM, where the header has one, is that of header and data.
  bool checksum_is_right() const { return checksum_is_right_; }

  /// The value of a keyword of the table's header; nothing if it is absent or of another kind.
  std::optional<std::string> text(std::string_view keyword) const;
  std::optional<double> number(std::string_view keyword) const;
  /// "kg m2" of a comment "[kg m2] …" beside the keyword's value; empty: none.
  std::string unit(std::string_view keyword) const;

  struct Column {
    std::vector<double> values;  ///< rows() x width; NaN where the file has none
    std::string unit;            ///< as written; empty: none
  };

  /// A column of `width` real numbers a row; nothing if no column has that name (any case). Throws InputError for
  /// another width or type.
  std::optional<Column> column(std::string_view name, std::size_t width) const;

 private:
  // Keyword and what follows "= "; of a long text that goes on in CONTINUE cards its parts, joined.
  using Header = std::map<std::string, std::string, std::less<>>;

  Header take_header(std::string_view& rest) const;
  void check_sums(std::string_view header, std::string_view data);
  std::size_t data_size(const Header& header) const;
  static std::optional<std::string> text(const Header& header, std::string_view keyword);
  static std::optional<std::string> text_of(std::string_view value);
  static std::optional<double> number(const Header& header, std::string_view keyword);
  std::size_t count(const Header& header, std::string_view keyword) const;

  std::string file_;
  Header header_;
  std::string_view data_;
  std::size_t rows_ = 0;
  std::size_t row_bytes_ = 0;
  bool checksum_is_right_ = true;
};

}  // namespace polhode
