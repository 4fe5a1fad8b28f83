#include "polhode/read/text_file.hpp"

#define ZLIB_CONST  // zlib then takes input that is constant
#include <zlib.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "polhode/base/error.hpp"

namespace polhode {

std::string read_text_file(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) throw InputError({path, 0}, "is a directory, a file is wanted");
  if (std::filesystem::is_character_file(path, ignored) || std::filesystem::is_block_file(path, ignored)) {
    throw InputError({path, 0}, "is a device, a file is wanted");  // /dev/zero has no end
  }
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw FileError("cannot open " + path + ": " + std::strerror(errno));
  std::ostringstream text;
  text << stream.rdbuf();
  if (stream.bad()) throw FileError("cannot read " + path + ": " + std::strerror(errno));
  if (text.str().empty()) throw InputError({path, 0}, "the file is empty");
  std::string content = std::move(text).str();
  if (content.starts_with("\x1f\x8b")) content = unpack_gzip(content, path);
  if (content.starts_with("\xEF\xBB\xBF")) content.erase(0, 3);
  return content;
}

std::string unpack_gzip(std::string_view packed, const std::string& name) {
  constexpr std::size_t always = 64U << 20U;
  constexpr std::size_t ratio = 100;
  struct Stream : z_stream {
    Stream() : z_stream{} {}
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;
    ~Stream() { inflateEnd(this); }
  } stream;
  constexpr int gzip_only = 16 + MAX_WBITS;
  if (inflateInit2(&stream, gzip_only) != Z_OK) throw FileError("cannot unpack " + name + ": no memory");
  std::string out;
  std::array<char, 1 << 16> buffer{};
  std::string_view rest = packed;
  while (true) {
    const std::size_t taken = std::min<std::size_t>(rest.size(), std::numeric_limits<uInt>::max());
    stream.next_in = reinterpret_cast<const Bytef*>(rest.data());
    stream.avail_in = static_cast<uInt>(taken);
    stream.next_out = reinterpret_cast<Bytef*>(buffer.data());
    stream.avail_out = static_cast<uInt>(buffer.size());
    const int status = inflate(&stream, Z_NO_FLUSH);
    rest.remove_prefix(taken - stream.avail_in);
    out.append(buffer.data(), buffer.size() - stream.avail_out);
    if (out.size() > always + ratio * packed.size()) {
      throw InputError({name, 0}, "unpacks to more than a hundred times its size");
    }
    if (status == Z_STREAM_END) {
      if (!rest.starts_with("\x1f\x8b")) return out;  // gzip files may be joined; what else follows is padding
      inflateReset(&stream);
    } else if (status != Z_OK || (rest.empty() && stream.avail_out == buffer.size())) {
      throw InputError(
          {name, 0}, status == Z_OK || status == Z_BUF_ERROR ? "the gzip file is cut off" : "the gzip file is broken");
    }
  }
}

}  // namespace polhode
