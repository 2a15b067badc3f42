#pragma once
/// The folder that a run writes to: one run at a time, and no finished one by mistake.

#include <cstdint>
#include <filesystem>

namespace berm {

/// Keeps other runs out as long as it lives; the system ends it with the process. On the first process only.
class FolderLock {
public:
  FolderLock() = default;
  /// Throws InputError if another run is writing there, RunError if the folder cannot be written to.
  explicit FolderLock(const std::filesystem::path& folder);
  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&& other) noexcept;
  ~FolderLock();

  /// False if something else has the folder's name now: moved away, removed, replaced by a link. True of one that locks nothing.
  bool has_folder() const;

private:
  std::filesystem::path file_;
  int descriptor_ = -1;
  std::uintmax_t folder_number_ = 0;  ///< of the system (inode)
};

/// Throws InputError if the folder holds the results of a run that came to its end.
void refuse_finished(const std::filesystem::path& folder);

/// Throws InputError if no run has written to the folder and it holds files that one would replace or remove: those of the user.
void refuse_foreign(const std::filesystem::path& folder);

/// Files of an earlier run in the same folder would mix with those of a new one.
void remove_old_results(const std::filesystem::path& folder);

}  // namespace berm
