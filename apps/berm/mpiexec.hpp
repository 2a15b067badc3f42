#pragma once
/// Runs on several processes without the user's calling mpiexec.

#include <string>
#include <vector>

/// Processes that an mpiexec started, this one among them; 1 without one.
int ranks_of_launcher();

/// Below run_under_mpiexec: whether what is printed reaches a terminal. mpiexec gives the processes one of its own in any
/// case.
bool user_sees_terminal();

/// Runs `mpiexec -n ranks berm ...` with the same arguments and returns its exit code. SIGINT and SIGTERM become SIGUSR1,
/// which mpiexec passes on at once and for which the processes end in good order; a second one ends them as they are.
int run_under_mpiexec(int ranks, const std::vector<std::string>& arguments);
