#pragma once
/// The tools that are written in Python.

#include <string>
#include <vector>

/// Replaces this process by the Python tool `module` with the given arguments. Returns only if Python is missing.
int run_python(const std::string& module, const std::vector<std::string>& arguments);
