#pragma once
/// A driver that keeps in memory what HDF5 itself writes of a file: its own tables, not the large arrays beside them. HDF5
/// 1.10 cannot close a file when the disk is full, and crashes on it when the process ends; in memory nothing fails, and what
/// then goes to the disk is in our hands. Seen by hdf5_file.cpp alone.

#include <hdf5.h>

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <vector>

namespace berm {

class Hdf5Memory {
public:
  void write(std::uint64_t at, std::span<const char> bytes);
  /// What was not written is zero.
  void read(std::uint64_t at, std::span<char> bytes) const;
  /// What was written, in the order of the file, every byte once.
  void for_each_part(const std::function<void(std::uint64_t at, std::span<const char> bytes)>& use) const;

  std::uint64_t room = 0;  ///< size of the file: what HDF5 has given away, the arrays that others write included

private:
  static constexpr std::uint64_t page_size = 4096;
  struct Range {
    std::uint64_t begin, end;
  };
  std::map<std::uint64_t, std::array<char, page_size>> pages_;  ///< by address over page_size
  std::vector<Range> written_;
};

/// Properties of access for H5Fcreate that put the file into `memory`, which must outlive it; the name does not count.
/// Negative if HDF5 refuses.
hid_t access_to_memory(Hdf5Memory& memory);

}  // namespace berm
