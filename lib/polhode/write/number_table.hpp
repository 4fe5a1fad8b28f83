#pragma once

#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "polhode/write/stream.hpp"

namespace polhode {

/// A column of numbers; in text each of several components has a column of its own.
struct NumberColumn {
  enum class Kind {
    number,  ///< doubles
    whole,   ///< whole numbers, given as doubles
    label,   ///< texts, given as their place in `labels`
  };
  std::string name;                     ///< of a FITS column
  std::vector<std::string> text_names;  ///< of the components in CSV and ECSV
  std::string unit;                     ///< empty: none
  Kind kind = Kind::number;
  std::vector<std::string> labels = {};
};

/// A table of numbers in one of the formats CSV, ECSV, FITS, and what is said of it.
struct NumberTable {
  std::string extension;  ///< EXTNAME of a FITS table
  std::vector<NumberColumn> columns;
  /// Keyword of FITS, key in ECSV, value (a number or a text), comment. CSV has those as comments.
  struct Entry {
    std::string keyword, key;
    std::string text;
    double number = 0.0;
    bool is_number = false;
    std::string comment;
  };
  std::vector<Entry> entries;
  std::vector<std::string> comments;
  std::size_t rows = 0;

  std::size_t width() const;  ///< numbers in a row
};

/// Puts the numbers of rows `first` on, as many as `out` holds, one row after the other. Called on several threads at
/// once.
using RowFiller = std::function<void(std::size_t first, std::span<double> out)>;

/// ".fits .fit (FITS), .csv (CSV), .ecsv (ECSV)", for help and messages.
std::string endings_of_number_tables();

/// Whether the path's ending names FITS.
bool is_fits_path(const std::string& path);

/// Throws InputError unless the path's ending names a format.
void check_number_table_path(const std::string& path);

/// Writes the table on `thread_count` threads, 0: one per core, in memory that does not depend on its length. The bytes
/// do not depend on the threads. Throws FileError, InputError for another ending, and what `fill` and `progress` throw;
/// then there is no file.
void write_number_table(const std::string& path, const NumberTable& table, const RowFiller& fill,
                        const Progress& progress = {}, unsigned thread_count = 0);

}  // namespace polhode
