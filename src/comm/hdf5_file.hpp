#pragma once
/// Checkpoint files: large arrays of all processes in one HDF5 file, written together, read by any number of processes.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "comm/comm.hpp"

namespace berm {

/// Version of the format that this program writes and reads.
constexpr int checkpoint_version = 4;

/// Errors: InputError for a file that is not what it should be, RunError for what the system refuses; both name the
/// file. Errors of create, open, write* and commit are thrown by all processes alike.
class CheckpointFile {
public:
  /// Begins PATH.part; a rest of an earlier, killed run there is overwritten. Collective, as is all writing. Every
  /// process must see the folder.
  static CheckpointFile create(const Comm& comm, const std::string& path);
  /// Opens a finished file. Collective; every process reads for itself afterwards.
  static CheckpointFile open(const Comm& comm, const std::string& path);

  CheckpointFile(CheckpointFile&&) noexcept;
  CheckpointFile& operator=(CheckpointFile&&) noexcept;
  /// What was not committed is removed.
  ~CheckpointFile();

  /// Writes this process's rows of `columns` values; the dataset has the rows of all in the order of rank. Folders in
  /// the name ("points/x") are made as needed.
  void write(const std::string& name, std::span<const double> mine, int columns = 1);
  void write(const std::string& name, std::span<const std::int64_t> mine, int columns = 1);
  void write(const std::string& name, std::span<const std::int32_t> mine, int columns = 1);
  void write(const std::string& name, std::span<const std::uint8_t> mine, int columns = 1);
  /// The same on every process. Without trailing NUL characters.
  void write_text(const std::string& name, const std::string& text);
  /// The same on every process; whole numbers are exact up to 2^53.
  void write_number(const std::string& name, double value);

  /// Closes the file, waits for the disk and renames PATH.part to PATH: a run killed before leaves the old file.
  void commit();

  /// Rows of all processes that wrote.
  std::int64_t rows(const std::string& name) const;
  bool has(const std::string& name) const;
  /// Rows first .. first + n - 1. T: double, std::int64_t, std::int32_t or std::uint8_t, as written.
  template <class T>
  std::vector<T> read_rows(const std::string& name, std::int64_t first, std::int64_t n, int columns = 1) const;
  std::string read_text(const std::string& name) const;
  double read_number(const std::string& name) const;

private:
  struct Impl;
  explicit CheckpointFile(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace berm
