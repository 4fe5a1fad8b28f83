#include "polhode/write/number_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <iterator>
#include <optional>
#include <thread>

#include "polhode/base/error.hpp"
#include "polhode/base/parallel.hpp"
#include "polhode/base/text.hpp"
#include "polhode/write/document.hpp"
#include "polhode/write/fits_file.hpp"
#include "polhode/write/number_text.hpp"
#include "polhode/write/output_file.hpp"

namespace polhode {
namespace {

using NumberKind = NumberColumn::Kind;

enum class NumberTableFormat { csv, ecsv, fits };

std::optional<NumberTableFormat> format_of_path(const std::string& path) {
  const std::string lower = lower_case(path);
  if (lower.ends_with(".csv")) return NumberTableFormat::csv;
  if (lower.ends_with(".ecsv")) return NumberTableFormat::ecsv;
  if (lower.ends_with(".fits") || lower.ends_with(".fit")) return NumberTableFormat::fits;
  return std::nullopt;
}

std::string quoted_cell(const std::string& text) {
  const std::string plain = plain_text(text);
  if (!plain.empty() && plain.find_first_of(",\"# ") == std::string::npos) return plain;
  std::string out = "\"";
  for (const char c : plain) out.append(c == '"' ? 2 : 1, c);
  return out + "\"";
}

/// Computes and encodes the rows in blocks, as many at a time as there are threads, and hands them on in order.
template <class Encode, class Consume>
void stream_numbers(const NumberTable& table, const RowFiller& fill, unsigned thread_count, const Encode& encode,
                    const Consume& consume) {
  constexpr std::size_t block = 8192;
  if (thread_count == 0) thread_count = std::max(1U, std::thread::hardware_concurrency());
  const std::size_t width = table.width();
  std::vector<std::vector<double>> numbers(thread_count, std::vector<double>(block * width));
  std::vector<EncodedBlock> encoded(thread_count);
  for (std::size_t first = 0; first < table.rows; first += block * thread_count) {
    const std::size_t blocks = std::min<std::size_t>(thread_count, (table.rows - first + block - 1) / block);
    parallel_chunks(blocks, 1, static_cast<unsigned>(blocks), [&](std::size_t begin, std::size_t end) {
      for (std::size_t b = begin; b < end; ++b) {
        const std::size_t at = first + b * block, rows = std::min(block, table.rows - at);
        const std::span<double> out(numbers[b].data(), rows * width);
        fill(at, out);
        encoded[b].rows = rows;
        encode(out, encoded[b]);
      }
    });
    for (std::size_t b = 0; b < blocks; ++b) consume(encoded[b]);
  }
}

std::string text_header(const NumberTable& table, NumberTableFormat format) {
  std::string out;
  if (format == NumberTableFormat::ecsv) {
    out = "# %ECSV 1.0\n# ---\n# delimiter: ','\n# datatype:\n";
    for (const NumberColumn& column : table.columns) {
      const char* type = column.kind == NumberKind::number  ? "float64"
                         : column.kind == NumberKind::whole ? "int64"
                                                            : "string";
      for (const std::string& name : column.text_names) {
        out += fmt::format("# - {{name: {}, datatype: {}{}}}\n", name, type,
                           column.unit.empty() ? "" : ", unit: " + column.unit);
      }
    }
    out += "# meta: !!omap\n";
    for (const NumberTable::Entry& entry : table.entries) {
      out += fmt::format("# - {{{}: {}}}\n", entry.key,
                         entry.is_number ? fmt::format("{}", entry.number) : double_quoted(entry.text));
    }
    for (std::size_t i = 0; i < table.comments.size(); ++i) {
      out += fmt::format("# - {{comment_{}: {}}}\n", i + 1, double_quoted(table.comments[i]));
    }
    out += "# schema: astropy-2.0\n";
  } else {
    for (const NumberTable::Entry& entry : table.entries) {
      out += fmt::format("# {}: {}\n", entry.key,
                         entry.is_number ? fmt::format("{}", entry.number) : plain_text(entry.text));
    }
    for (const std::string& comment : table.comments) out += fmt::format("# {}\n", plain_text(comment));
  }
  const char* separator = "";
  for (const NumberColumn& column : table.columns) {
    for (const std::string& name : column.text_names) {
      out += separator + name;
      separator = ",";
    }
  }
  return out + "\n";
}

void write_number_text(const std::string& path, const NumberTable& table, NumberTableFormat format,
                       const RowFiller& fill, const Progress& progress, unsigned thread_count) {
  std::vector<NumberKind> kinds;
  std::vector<std::vector<std::string>> labels;  // of each column
  for (const NumberColumn& column : table.columns) {
    std::vector<std::string> cells(column.labels.size());
    std::transform(column.labels.begin(), column.labels.end(), cells.begin(), quoted_cell);
    kinds.insert(kinds.end(), column.text_names.size(), column.kind);
    labels.insert(labels.end(), column.text_names.size(), cells);
  }
  const auto encode = [&](std::span<const double> numbers, EncodedBlock& out) {
    out.bytes.clear();
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const std::size_t column = i % kinds.size();
      const char before = column == 0 ? '\n' : ',';
      switch (kinds[column]) {
        case NumberKind::number:
          append_number(out.bytes, before, numbers[i]);
          break;
        case NumberKind::whole:
          fmt::format_to(std::back_inserter(out.bytes), "{}{}", before, static_cast<std::int64_t>(numbers[i]));
          break;
        case NumberKind::label:
          out.bytes.append(1, before).append(labels[column][static_cast<std::size_t>(numbers[i])]);
          break;
      }
    }
    out.bytes.erase(0, 1);
    out.bytes.push_back('\n');
  };
  OutputBytes bytes(path);
  bytes.write(text_header(table, format));
  std::size_t written = 0;
  stream_numbers(table, fill, thread_count, encode, [&](const EncodedBlock& block) {
    bytes.write(block.bytes);
    written += block.rows;
    if (progress) progress(written);
  });
  bytes.commit();
}

/// Big-endian bytes, and the sum of their 32-bit words: all columns are whole words.
void write_fits_rows(FitsFile& fits, const NumberTable& table, const RowFiller& fill, const Progress& progress,
                     unsigned thread_count) {
  int status = 0;
  fits_create_img(fits.handle(), BYTE_IMG, 0, nullptr, &status);
  fits.check(status);
  fits.checksums(0);
  std::vector<std::string> names, forms, units;
  std::vector<NumberKind> kinds;
  std::vector<std::vector<std::string>> labels;  // of each number of a row, all of one length
  std::size_t row_bytes = 0;
  for (const NumberColumn& column : table.columns) {
    const std::size_t width = column.text_names.size();
    std::size_t longest = 4;
    for (const std::string& label : column.labels) longest = std::max(longest, (ascii_text(label).size() + 3) / 4 * 4);
    std::vector<std::string> texts(column.labels.size());
    std::transform(column.labels.begin(), column.labels.end(), texts.begin(), [longest](const std::string& label) {
      std::string text = ascii_text(label);
      text.resize(longest, '\0');
      return text;
    });
    names.push_back(column.name);
    units.push_back(column.unit);
    forms.push_back(column.kind == NumberKind::label
                        ? fmt::format("{}A", longest)
                        : fmt::format("{}{}", width, column.kind == NumberKind::whole ? 'K' : 'D'));
    kinds.insert(kinds.end(), width, column.kind);
    labels.insert(labels.end(), width, texts);
    row_bytes += column.kind == NumberKind::label ? longest : width * sizeof(double);
  }
  const auto pointers = [](std::vector<std::string>& texts) {
    std::vector<char*> out(texts.size());
    std::transform(texts.begin(), texts.end(), out.begin(), [](std::string& text) { return text.data(); });
    return out;
  };
  fits_create_tbl(fits.handle(), BINARY_TBL, 0, static_cast<int>(names.size()), pointers(names).data(),
                  pointers(forms).data(), pointers(units).data(), table.extension.c_str(), &status);
  fits.check(status);
  fits.announce_long_texts();
  for (const NumberTable::Entry& entry : table.entries) {
    if (entry.is_number) {
      fits.key(entry.keyword.c_str(), entry.number, entry.comment.c_str());
    } else {
      fits.key(entry.keyword.c_str(), entry.text, entry.comment.c_str());
    }
  }
  for (const std::string& comment : table.comments) fits.comment(comment);
  fits.leave_room_for_checksums();

  const auto encode = [&](std::span<const double> numbers, EncodedBlock& out) {
    out.bytes.resize(out.rows * row_bytes);
    FitsPacker packer(out.bytes.data());
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const std::size_t column = i % kinds.size();
      switch (kinds[column]) {
        case NumberKind::number:
          packer.put(numbers[i]);
          break;
        case NumberKind::whole:
          packer.put(std::bit_cast<double>(static_cast<std::int64_t>(numbers[i])));
          break;
        case NumberKind::label:
          packer.put_words(labels[column][static_cast<std::size_t>(numbers[i])]);
          break;
      }
    }
    out.word_sum = packer.sum();
  };
  LONGLONG written = 0;
  std::uint64_t data_sum = 0;
  stream_numbers(table, fill, thread_count, encode, [&](EncodedBlock& block) {
    errno = 0;
    auto* bytes = reinterpret_cast<unsigned char*>(block.bytes.data());
    fits_write_tblbytes(fits.handle(), written + 1, 1, static_cast<LONGLONG>(block.bytes.size()), bytes, &status);
    fits.check(status);
    data_sum = fits_sum(data_sum + fits_sum(block.word_sum));
    written += static_cast<LONGLONG>(block.rows);
    if (progress) progress(static_cast<std::size_t>(written));
  });
  errno = 0;
  fits_flush_file(fits.handle(), &status);  // notes the count of rows in the header
  fits.check(status);
  fits.checksums(data_sum);
  fits.close();
}

}  // namespace

std::size_t NumberTable::width() const {
  std::size_t sum = 0;
  for (const NumberColumn& column : columns) sum += column.text_names.size();
  return sum;
}

std::string endings_of_number_tables() { return ".fits .fit (FITS), .csv (CSV), .ecsv (ECSV)"; }

bool is_fits_path(const std::string& path) { return format_of_path(path) == NumberTableFormat::fits; }

void check_number_table_path(const std::string& path) {
  if (!format_of_path(path)) {
    throw InputError(
        fmt::format("{}: the ending says the format; one of {} is wanted", path, endings_of_number_tables()));
  }
}

void write_number_table(const std::string& path, const NumberTable& table, const RowFiller& fill,
                        const Progress& progress, unsigned thread_count) {
  check_number_table_path(path);
  const NumberTableFormat format = *format_of_path(path);
  if (format != NumberTableFormat::fits) {
    write_number_text(path, table, format, fill, progress, thread_count);
    return;
  }
  OutputFile output(path);
  FitsFile fits(output.temporary_path(), path);
  output.keep_mode();
  write_fits_rows(fits, table, fill, progress, thread_count);
  output.commit();
}

}  // namespace polhode
