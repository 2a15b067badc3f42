#pragma once
/// The tools that are written in Python.

#include <string>
#include <vector>

/// Replaces this process by the tool of that name (a module of python/berm) with the given arguments. Returns only if Python is missing.
int run_python(const std::string& tool, const std::vector<std::string>& arguments);
