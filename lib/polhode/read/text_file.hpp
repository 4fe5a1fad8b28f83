#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

namespace polhode {

/// The most bytes of a file, after unpacking: readers hold it in memory, some several times over.
inline constexpr std::size_t most_text_bytes = std::size_t{512} << 20U;
inline constexpr std::size_t most_fits_bytes = std::size_t{2048} << 20U;

/// The whole of a file or pipe as bytes, unpacked if it is compressed by gzip, without a byte-order mark of UTF-8.
/// Throws InputError for a directory, a device, an empty file and one beyond the limits above, FileError where it
/// cannot be read.
std::string read_text_file(const std::string& path);

/// What gzip has packed; `name` stands for the file in messages. Throws InputError for broken or cut-off content,
/// beyond the limits above, and where a byte unpacks to more than 100 beyond the first 64 MB: no table of attitudes
/// does.
std::string unpack_gzip(std::string_view packed, const std::string& name);

/// How readers whose file names other files get the content of these; read_text_file unless said.
using ContentOf = std::function<std::string(const std::string& path)>;

}  // namespace polhode
