#include "polhode/write/output_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

namespace polhode {
namespace {

namespace fs = std::filesystem;

FileError failure(const std::string& path, int error) {
  return FileError(fmt::format("cannot write {}: {}", path, std::strerror(error)));
}

/// The hidden files that there are, for a handler of signals: nothing but loads and stores that need no lock.
std::array<std::atomic<const char*>, 64> hidden_files{};
static_assert(std::atomic<const char*>::is_always_lock_free);

void sync(const std::string& path, const std::string& reported, int flags) {
  const int descriptor = ::open(path.c_str(), flags | O_CLOEXEC);
  if (descriptor < 0) throw failure(reported, errno);
  const int result = ::fsync(descriptor);
  const int error = errno;
  ::close(descriptor);
  if (result != 0 && error != EINVAL) throw failure(reported, error);  // EINVAL: a file system without fsync
}

/// The path where a file stands, or would: absolute, without links.
fs::path behind_links(const std::string& path) {
  constexpr int most_links = 40;  // as Linux has it
  std::error_code error;
  fs::path wanted = fs::absolute(path, error);
  for (int links = 0; !error && fs::is_symlink(fs::symlink_status(wanted, error)); ++links) {
    if (links == most_links) throw failure(path, ELOOP);
    wanted = wanted.parent_path() / fs::read_symlink(wanted, error);
  }
  // What is not there has no status, and needs none.
  if (error && error != std::errc::no_such_file_or_directory) throw failure(path, error.value());
  const fs::path folder = fs::canonical(wanted.parent_path(), error);
  if (error == std::errc::no_such_file_or_directory || (!error && !fs::is_directory(folder))) {
    throw FileError(fmt::format("cannot write {}: there is no folder {}", path, wanted.parent_path().string()));
  }
  if (error) throw failure(path, error.value());
  return folder / wanted.filename();
}

std::string checked(const std::string& path) {
  if (path.find('\0') != std::string::npos) {
    throw FileError(
        fmt::format("cannot write {}: the path goes on with the character U+0000", path.substr(0, path.find('\0'))));
  }
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::exists(status)) {
    if (!fs::is_regular_file(status)) {
      throw FileError(fmt::format("cannot write {}: it exists and is not a regular file", path));
    }
    // Renaming would ask the folder only; and a root may write what is meant to be kept.
    constexpr auto writable = fs::perms::owner_write | fs::perms::group_write | fs::perms::others_write;
    if ((status.permissions() & writable) == fs::perms::none) {
      throw FileError(fmt::format("cannot write {}: it exists and is read-only", path));
    }
    if (::access(path.c_str(), W_OK) != 0) throw failure(path, errno);
  }
  return behind_links(path).string();
}

/// Of /dev/stdout, /dev/fd/3 and the like the number of the open file, else -1.
int own_descriptor(const std::string& path) {
  if (path == "/dev/stdout") return STDOUT_FILENO;
  if (path == "/dev/stderr") return STDERR_FILENO;
  for (const std::string_view folder : {"/dev/fd/", "/proc/self/fd/"}) {
    if (!path.starts_with(folder)) continue;
    const auto number = std::string_view(path).substr(folder.size());
    if (number.empty() || number.size() > 6 || number.find_first_not_of("0123456789") != std::string_view::npos)
      continue;
    return std::stoi(std::string(number));
  }
  return -1;
}

}  // namespace

HiddenFile::HiddenFile(const std::string& folder) {
  static std::atomic<unsigned> serial{0};
  path_ = (fs::path(folder) / fmt::format(".polhode-{}-{}", ::getpid(), serial++)).string();
  for (std::atomic<const char*>& place : hidden_files) {
    const char* free = nullptr;
    if (place.compare_exchange_strong(free, path_.c_str())) break;
  }
}

HiddenFile::~HiddenFile() {
  ::unlink(path_.c_str());
  for (std::atomic<const char*>& place : hidden_files) {
    const char* own = path_.c_str();
    if (place.compare_exchange_strong(own, nullptr)) break;
  }
}

bool remove_hidden_files() noexcept {
  bool any = false;
  for (const std::atomic<const char*>& place : hidden_files) {
    if (const char* path = place.load()) any = ::unlink(path) == 0 || any;
  }
  return any;
}

OutputFile::OutputFile(const std::string& path)
    : path_(checked(path)), hidden_(fs::path(path_).parent_path().string()) {}

void OutputFile::keep_mode() const {
  struct stat old {};
  if (::stat(path_.c_str(), &old) != 0) return;  // there is none
  const std::string& path = temporary_path();
  constexpr mode_t all = 07777;
  constexpr mode_t without_identity = 01777;
  const bool same_owner = ::chown(path.c_str(), old.st_uid, old.st_gid) == 0;  // else a file of our own
  if (::chmod(path.c_str(), old.st_mode & (same_owner ? all : without_identity)) != 0) throw failure(path_, errno);
}

void OutputFile::commit() {
  keep_mode();
  sync(temporary_path(), path_, O_RDONLY);
  if (std::rename(temporary_path().c_str(), path_.c_str()) != 0) throw failure(path_, errno);
  sync(fs::path(path_).parent_path().string(), path_, O_RDONLY | O_DIRECTORY);
}

bool is_passed_through(const std::string& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  return own_descriptor(path) >= 0 || fs::is_fifo(status) || fs::is_character_file(status);
}

OutputBytes::OutputBytes(const std::string& path) : path_(path) {
  if (is_passed_through(path)) {
    const int own = own_descriptor(path);
    descriptor_ = own >= 0 ? ::fcntl(own, F_DUPFD_CLOEXEC, 0) : ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  } else {
    file_.emplace(path);
    constexpr int everybody_as_umask_allows = 0666;
    descriptor_ =
        ::open(file_->temporary_path().c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, everybody_as_umask_allows);
  }
  if (descriptor_ < 0) throw failure(path, errno);
  if (file_) file_->keep_mode();
}

OutputBytes::~OutputBytes() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void OutputBytes::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0 && errno == EPIPE) throw PipeClosed(failure(path_, errno).what());
    if (written < 0) throw failure(path_, errno);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void OutputBytes::commit() {
  const int result = ::close(descriptor_);
  descriptor_ = -1;
  if (result != 0) throw failure(path_, errno);
  if (file_) file_->commit();
}

std::string OutputBytes::scratch_folder() const {
  if (file_) return fs::path(file_->path()).parent_path().string();
  std::error_code error;
  const fs::path folder = fs::temp_directory_path(error);
  if (error) throw failure(path_, error.value());
  return folder.string();
}

}  // namespace polhode
