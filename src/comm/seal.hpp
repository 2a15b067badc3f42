#pragma once
/// A checksum in the first bytes of a file, which says whether anything in the rest has changed since it was written.

#include <string>

namespace berm {

/// Bytes that the seal takes: the smallest user block that HDF5 leaves at the beginning of its files.
constexpr int seal_size = 512;

/// What belongs into the first bytes of a file that is complete otherwise. Throws std::system_error.
std::string seal_of(const std::string& path);
/// What is wrong with the seal of a file, or nothing. Throws std::system_error.
std::string broken_seal(const std::string& path);

}  // namespace berm
