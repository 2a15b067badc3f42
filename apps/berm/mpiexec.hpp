#pragma once
/// Runs on several processes without the user's calling mpiexec.

#include <string>
#include <vector>

/// Processes that an mpiexec started, this one among them; 1 without one.
int ranks_of_launcher();

/// Below run_under_mpiexec: whether what is printed reaches a terminal. mpiexec gives the processes one of its own in any
/// case.
bool user_sees_terminal();

/// Below run_under_mpiexec: the first process calls it once MPI has started.
void say_begun();

/// Below run_under_mpiexec: the first process calls it once signals end the run in good order.
void say_ready();

/// Path of this program.
std::string own_path();

/// Throws InputError if that many processes would share cores and the user has not said that they may, or if they are so
/// many that the machine would be of no use to anybody.
void check_processes(int ranks, bool oversubscribe);

/// Runs `mpiexec -n ranks berm ...` with the same arguments and returns its exit code; `input` is what the first process reads
/// from standard input. SIGINT, SIGTERM, SIGHUP and SIGXCPU become SIGUSR1, which mpiexec passes on at once and for which the processes
/// end in good order; one that comes before they listen (say_ready) waits, a second one ends them as they are. Throws RunError
/// if mpiexec cannot work here.
int run_under_mpiexec(int ranks, const std::vector<std::string>& arguments, const std::string& input);
