#pragma once
/// Open MPI's folder for temporary files, without which it ends in forty lines of its own.

#include <filesystem>

/// Sets TMPDIR to a folder that can be written to, and says so, if the one that the environment names cannot; `out`: the last
/// choice. Throws RunError if there is none.
void look_for_temporary_folder(int processes, const std::filesystem::path& out);
