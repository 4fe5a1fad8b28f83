#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "polhode/base/error.hpp"

namespace polhode {

/// Whoever reads the output has closed it.
class PipeClosed : public FileError {
 public:
  using FileError::FileError;
};

/// A name for a hidden file ".polhode-…" of a folder, short whatever the wanted file is called. The destructor removes
/// the file, if there is one.
class HiddenFile {
 public:
  explicit HiddenFile(const std::string& folder);
  HiddenFile(const HiddenFile&) = delete;
  HiddenFile& operator=(const HiddenFile&) = delete;
  ~HiddenFile();

  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// Removes every hidden file that there is now, and says whether there was one; for a handler of signals that end the
/// program (it is async-signal-safe; of more than 64 files at once it knows 64).
bool remove_hidden_files() noexcept;

/// An output file that appears whole or not at all: everything is written to temporary_path(), a hidden file beside the
/// wanted one, and commit() puts that in its place in one step, with the mode and, if allowed, the owner of the file
/// that was there. Without commit() the destructor removes it. A process killed outright can leave the hidden file
/// behind, never a part under the wanted name.
class OutputFile {
 public:
  /// Symbolic links in `path` are followed, also to a file that is not there yet. Throws FileError if the path's folder
  /// does not exist, the file may not be written, or the path is a folder, a device or a pipe.
  explicit OutputFile(const std::string& path);

  const std::string& path() const { return path_; }

  /// Beside the wanted file; it does not exist yet.
  const std::string& temporary_path() const { return hidden_.path(); }

  /// Gives the temporary file, once it exists, the mode of the file that it replaces. commit() does so anyhow; a
  /// writer that calls this before its first byte lets nobody read them who could not read the old file.
  void keep_mode() const;

  /// Forces the temporary file to the disk and renames it. Throws FileError.
  void commit();

 private:
  std::string path_;
  HiddenFile hidden_;
};

/// Whether a path is written to as it is, since nothing can take its place: a pipe, a character device, one of the
/// program's own open files (/dev/stdout, /dev/fd/3).
bool is_passed_through(const std::string& path);

/// Bytes in order, to an OutputFile, or to what is passed through.
class OutputBytes {
 public:
  /// Throws FileError, as OutputFile.
  explicit OutputBytes(const std::string& path);
  OutputBytes(const OutputBytes&) = delete;
  OutputBytes& operator=(const OutputBytes&) = delete;
  ~OutputBytes();

  /// Throws FileError with the system's reason (disk full …), PipeClosed if nobody reads them any more.
  void write(std::string_view bytes);

  void commit();

  /// Where a hidden file for work on the way to this output may stand: beside it, or in the system's place for them.
  std::string scratch_folder() const;

 private:
  std::string path_;
  std::optional<OutputFile> file_;  // none: passed through
  int descriptor_ = -1;
};

}  // namespace polhode
