#pragma once
/// Mesh files of tests.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "base/error.hpp"
#include "mesh/gmsh.hpp"

namespace berm::msh_file {

/// A file in the test's own folder, removed at the end.
class File {
public:
  explicit File(const std::string& text) {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    path_ = std::filesystem::temp_directory_path() / (std::string("berm_") + info->name() + ".msh");
    std::ofstream(path_, std::ios::binary) << text;
  }
  ~File() { std::filesystem::remove(path_); }
  std::string path() const { return path_.string(); }

private:
  std::filesystem::path path_;
};

inline std::string error_of(const std::string& path) {
  try {
    read_msh(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos);
  return text.replace(at, from.size(), to);
}

}  // namespace berm::msh_file
