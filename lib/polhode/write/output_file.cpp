#include "polhode/write/output_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "polhode/base/error.hpp"

namespace polhode {
namespace {

FileError failure(const std::string& path, int error) {
  return FileError(fmt::format("cannot write {}: {}", path, std::strerror(error)));
}

void sync(const std::string& path, const std::string& reported, int flags) {
  const int descriptor = ::open(path.c_str(), flags | O_CLOEXEC);
  if (descriptor < 0) throw failure(reported, errno);
  const int result = ::fsync(descriptor);
  const int error = errno;
  ::close(descriptor);
  if (result != 0 && error != EINVAL) throw failure(reported, error);  // EINVAL: a file system without fsync
}

}  // namespace

OutputFile::OutputFile(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw FileError(fmt::format("cannot write {}: it exists and is not a regular file", path));
  }
  // Absolute first: a name alone, of a file that is not there yet, would keep no folder.
  const fs::path absolute = fs::absolute(path, error);
  const fs::path wanted = error ? fs::path() : fs::weakly_canonical(absolute, error);
  if (error) throw FileError(fmt::format("cannot write {}: {}", path, error.message()));
  if (!fs::is_directory(wanted.parent_path())) {
    throw FileError(fmt::format("cannot write {}: there is no folder {}", path, wanted.parent_path().string()));
  }
  static std::atomic<unsigned> serial{0};
  path_ = wanted.string();
  temporary_path_ =
      (wanted.parent_path() / fmt::format(".polhode-{}-{}-{}", ::getpid(), serial++, wanted.filename().string()))
          .string();
}

OutputFile::~OutputFile() {
  if (!committed_) ::unlink(temporary_path_.c_str());
}

void OutputFile::commit() {
  sync(temporary_path_, path_, O_RDONLY);
  if (std::rename(temporary_path_.c_str(), path_.c_str()) != 0) throw failure(path_, errno);
  committed_ = true;
  sync(std::filesystem::path(path_).parent_path().string(), path_, O_RDONLY | O_DIRECTORY);
}

OutputBytes::OutputBytes(const std::string& path) : file_(path) {
  constexpr int everybody_as_umask_allows = 0666;
  descriptor_ =
      ::open(file_.temporary_path().c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, everybody_as_umask_allows);
  if (descriptor_ < 0) throw failure(path, errno);
}

OutputBytes::~OutputBytes() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void OutputBytes::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw failure(file_.path(), errno);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void OutputBytes::commit() {
  const int result = ::close(descriptor_);
  descriptor_ = -1;
  if (result != 0) throw failure(file_.path(), errno);
  file_.commit();
}

}  // namespace polhode
