#pragma once
/// A file being written: every failure (no such folder, no permission, disk full) is a RunError that names the file.

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

namespace berm {

class OutputFile {
public:
  /// Makes a file in the place of what has that name, links too (base/system_file.hpp), or goes on at the end of one. Throws
  /// RunError if that is not possible.
  explicit OutputFile(std::string path, bool append = false);

  /// Throws RunError if the bytes cannot be written.
  void write(std::string_view bytes);
  /// Hands everything to the operating system, so that it outlives a killed run. Throws RunError.
  void flush();
  /// Closes the file; a full disk may show only here. Throws RunError. The destructor closes silently.
  void close();

  /// Throws RunError if something else has removed, replaced or cut the file since it was last flushed. Not of files that are
  /// appended to.
  void check_unchanged() const;

  const std::string& path() const { return path_; }

private:
  [[noreturn]] void fail() const;

  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::string path_;
  std::uintmax_t written_ = 0;  ///< bytes
  std::unique_ptr<std::FILE, Closer> file_;
};

/// Replaces the file as a whole: a reader, or a run killed half-way, sees the old or the new content, never a part of
/// it. Throws RunError.
void replace_file(const std::string& path, std::string_view content);

}  // namespace berm
