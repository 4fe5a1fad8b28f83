#include "polhode/read/text_file.hpp"

#define ZLIB_CONST  // zlib then takes input that is constant
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <limits>
#include <new>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

/// An open file.
class Descriptor {
 public:
  explicit Descriptor(const std::string& path) : number_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (number_ < 0) throw FileError("cannot open " + path + ": " + std::strerror(errno));
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { ::close(number_); }
  int operator()() const { return number_; }

 private:
  int number_;
};

/// Whether there are more bytes than are read of this content, of which at least the begin is known.
bool is_too_large(std::size_t bytes, std::string_view content) {
  return bytes > (content.starts_with("SIMPLE  =") ? most_fits_bytes : most_text_bytes);
}

InputError too_large(const std::string& path) {
  return {{path, 0},
          fmt::format("is too large: at most {} MiB are read, of FITS {} MiB (unpacked)", most_text_bytes >> 20U,
                      most_fits_bytes >> 20U)};
}

std::string content_of(const std::string& path) {
  const Descriptor file(path);
  struct stat about {};
  if (::fstat(file(), &about) != 0) throw FileError("cannot read " + path + ": " + std::strerror(errno));
  if (S_ISDIR(about.st_mode)) throw InputError({path, 0}, "is a directory, a file is wanted");
  if (S_ISCHR(about.st_mode) || S_ISBLK(about.st_mode)) {
    throw InputError({path, 0}, "is a device, a file is wanted");  // /dev/zero has no end
  }
  constexpr std::size_t at_once = 1U << 18U;
  const auto size = static_cast<std::size_t>(about.st_size);  // of pipes 0
  std::string content;
  for (std::size_t end = 0;;) {
    content.resize(end + at_once);
    const ssize_t count = ::read(file(), content.data() + end, at_once);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw FileError("cannot read " + path + ": " + std::strerror(errno));
    if (end == 0) {
      if (is_too_large(size, content)) throw too_large(path);
      content.reserve(size + at_once);
    }
    end += static_cast<std::size_t>(count);
    content.resize(end);
    if (count == 0) break;
    if (is_too_large(end, content)) throw too_large(path);
  }
  if (content.empty()) throw InputError({path, 0}, "the file is empty");
  if (content.starts_with("\x1f\x8b")) content = unpack_gzip(content, path);
  if (content.starts_with("\xEF\xBB\xBF")) content.erase(0, 3);
  const std::string_view begin = std::string_view(content).substr(0, 2);
  if (begin == "\xff\xfe" || begin == "\xfe\xff" || begin == std::string_view("<\0", 2) ||
      begin == std::string_view("\0<", 2)) {
    throw InputError({path, 0}, "is text in UTF-16 or UTF-32, and UTF-8 is read; iconv -f UTF-16 -t UTF-8 makes it");
  }
  return content;
}

}  // namespace

std::string read_text_file(const std::string& path) {
  if (path.find('\0') != std::string::npos) {
    throw InputError("the path that begins with '" + path.substr(0, path.find('\0')) +
                     "' holds the character U+0000, which no name of a file does");
  }
  try {
    return content_of(path);
  } catch (const std::bad_alloc&) {
    throw FileError("cannot read " + path + ": there is not enough memory");
  }
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
    if (is_too_large(out.size(), out)) throw too_large(name);
    if (out.size() > always + ratio * packed.size()) {
      throw InputError({name, 0}, "unpacks to more than a hundred times its size");
    }
    if (status == Z_STREAM_END) {
      if (rest.find_first_not_of('\0') == std::string_view::npos) return out;  // zeros are padding
      if (!rest.starts_with("\x1f\x8b")) {                                     // gzip files may be joined
        throw InputError({name, 0}, "something else follows the data that gzip packed");
      }
      inflateReset(&stream);
    } else if (status != Z_OK || (rest.empty() && stream.avail_out == buffer.size())) {
      throw InputError(
          {name, 0}, status == Z_OK || status == Z_BUF_ERROR ? "the gzip file is cut off" : "the gzip file is broken");
    }
  }
}

}  // namespace polhode
