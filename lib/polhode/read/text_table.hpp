#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "polhode/base/error.hpp"
#include "polhode/base/located.hpp"

namespace polhode {

/// The cells of a line of a table, between commas or, if `comma` is not set, between white space. A cell in quotes may
/// hold either, and quotes doubled. `cells` keeps its memory from line to line.
void split_cells(std::string_view line, bool comma, std::vector<std::string>& cells);

/// What the comments before a table say of it: the YAML of an ECSV header, as astropy and we write it.
class EcsvHeader {
 public:
  /// The first column of times: all that is said of it, empty where nothing is.
  struct Time {
    std::string name, format, scale, value, jd1, jd2;
  };

  /// The comments one after the other, each without its '#'.
  void take(std::string_view comment);

  /// The unit of a column; empty: none is given.
  std::string_view unit(std::string_view column) const { return find(units_, column); }
  /// "ICRF" of an entry {frame_a: "ICRF"}; empty if there is none.
  std::string_view entry(std::string_view key) const { return find(entries_, key); }
  /// "utc" of a line "scale: utc"; empty if there is none.
  const std::string& scale() const { return scale_; }
  const Time& time() const { return time_; }

 private:
  using Texts = std::vector<std::pair<std::string, std::string>>;
  static std::string_view find(const Texts& texts, std::string_view key);

  Texts units_, entries_;
  std::string scale_, last_key_;
  Time time_;
  bool in_time_ = false;
};

/// A table of text: comments behind #, which may be an ECSV header, a line of names, and rows. White space separates
/// the cells where there is no comma between the names.
class TextTable {
 public:
  /// Where comments are: on lines of their own, or behind cells as well.
  enum class Comments { on_lines, anywhere };

  /// Reads as far as the line of names. `text` must outlive the table, `path` stands in messages.
  TextTable(std::string_view text, std::string path, Comments comments = Comments::on_lines);

  const EcsvHeader& header() const { return header_; }
  const std::vector<std::string>& names() const { return names_; }  ///< empty: there is no line of names
  /// The column of that name; names().size() if there is none. Throws InputError if there are two.
  std::size_t column(std::string_view name) const;
  /// Throws InputError if the header gives a column another unit than one of these, between blanks; none: empty.
  void check_unit(std::size_t column, std::string_view allowed) const;

  /// Goes to the next row; false at the end. Throws InputError unless it has as many cells as there are names.
  bool next();
  const std::string& cell(std::size_t column) const { return cells_[column]; }
  /// Throws InputError for what is no number.
  double number(std::size_t column) const;

  SourceLocation here() const { return {path_, line_}; }  ///< the line that was read last
  InputError error(const std::string& message) const { return {here(), message}; }
  /// Runs `work`, and gives an InputError of its own this line.
  template <class Work>
  auto located(const Work& work) const {
    return polhode::located(here(), work);
  }

 private:
  std::string_view take_content();

  std::string_view rest_;
  std::string path_;
  Comments comments_;
  std::size_t line_ = 0;
  bool comma_ = false;
  EcsvHeader header_;
  std::vector<std::string> names_, cells_;
};

}  // namespace polhode
