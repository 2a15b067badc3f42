#pragma once
/// The MPI communicator behind a Comm, for libraries that want one. Only for modules that may see MPI.

#include <mpi.h>

#include <cstring>

#include "comm/comm.hpp"

namespace berm {

/// MPI_COMM_SELF for a process alone; MPI must run.
inline MPI_Comm mpi_comm(const Comm& comm) {
  MPI_Comm mpi = MPI_COMM_SELF;
  if (comm.handle()) std::memcpy(&mpi, comm.handle(), sizeof(mpi));
  return mpi;
}

}  // namespace berm
