#pragma once

#include <string>
#include <string_view>

namespace polhode {

/// An output file that appears whole or not at all: everything is written to temporary_path(), a hidden file beside the
/// wanted one, and commit() puts that in its place in one step. Without commit() the destructor removes it. A process
/// killed outright can leave the hidden file behind, never a part under the wanted name.
class OutputFile {
 public:
  /// Symbolic links in `path` are followed. Throws FileError if the path's folder does not exist or the path is a
  /// folder, a device or a pipe.
  explicit OutputFile(const std::string& path);
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile();

  const std::string& path() const { return path_; }

  /// Beside the wanted file and with the same ending; it does not exist yet.
  const std::string& temporary_path() const { return temporary_path_; }

  /// Forces the temporary file to the disk and renames it. Throws FileError.
  void commit();

 private:
  std::string path_;
  std::string temporary_path_;
  bool committed_ = false;
};

/// An OutputFile for bytes in order.
class OutputBytes {
 public:
  explicit OutputBytes(const std::string& path);
  OutputBytes(const OutputBytes&) = delete;
  OutputBytes& operator=(const OutputBytes&) = delete;
  ~OutputBytes();

  /// Throws FileError with the system's reason (disk full …).
  void write(std::string_view bytes);

  void commit();

 private:
  OutputFile file_;
  int descriptor_ = -1;
};

}  // namespace polhode
