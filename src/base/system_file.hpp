#pragma once
/// What all that writes files asks the operating system for.

#include <functional>
#include <string>
#include <string_view>

namespace berm {

/// Opens a file of its own for writing and returns its descriptor, or -1 with errno: what stands at the name makes way, so
/// that nothing is written through a symbolic or hard link to somewhere else. Devices are written to as they are.
int open_new_file(const std::string& path);
/// The same for going on at the end of a file that may be there; a symbolic link is refused.
int open_to_append(const std::string& path);

/// So many at least, if the system lets them be. Throws RunError if not.
void raise_limit_of_open_files(unsigned long needed);

std::string host_name();

/// Rank of this process among those that an mpiexec has started, as its environment has it before MPI begins; null without one.
const char* rank_of_launcher();
/// Of several processes the one that speaks; true without an mpiexec.
bool is_first_process();

/// Whether a variable of that name says something to Open MPI.
inline bool is_setting_of_mpi(std::string_view name) { return name.starts_with("OMPI_") || name.starts_with("OPAL_") || name.starts_with("PMIX_"); }

/// Takes the variables of such names out of the environment.
void forget_variables(const std::function<bool(std::string_view)>& is_such);

/// A fault (SIGSEGV and the like) ends the process by its signal, as ever, but with a line that says so.
void say_faults();

/// The words of the operating system for an errno and, where there is one, what to do.
std::string system_reason(int error);

}  // namespace berm
