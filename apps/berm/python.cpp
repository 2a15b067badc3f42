#include "python.hpp"
#include "streams.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>

#include "base/system_file.hpp"

namespace {

/// What a user has set for other Pythons may keep this one from starting, or from ending (PYTHONHOME, PYTHONINSPECT). Where packages are, and
/// what is written beside them, counts.
void forget_other_pythons(bool chosen) {
  berm::forget_variables([chosen](std::string_view name) {
    const bool counts = name == "PYTHONPATH" || name == "PYTHONNOUSERSITE" || name == "PYTHONDONTWRITEBYTECODE" || name == "PYTHONPYCACHEPREFIX" || (chosen && name == "PYTHONHOME");
    return name.starts_with("PYTHON") && !counts;
  });
}

}  // namespace

int run_python(const std::string& tool, const std::vector<std::string>& arguments) {
  // Debian's own interpreter has matplotlib and VTK; another one first in the PATH may not.
  const char* given = std::getenv("BERM_PYTHON");
  const bool chosen = given && *given;
  const char* interpreter = chosen ? given : "/usr/bin/python3";
  forget_other_pythons(chosen);
  const char* path = std::getenv("PYTHONPATH");
  const std::string python_path = std::string(BERM_PYTHON_DIR) + (path && *path ? std::string(":") + path : "");
  setenv("PYTHONPATH", python_path.c_str(), 1);
  setenv("PYTHONSAFEPATH", "1", 1);  // else files of the user in the current folder would stand for Python's own: json.py, numbers.py
  // Python looks for its packages beside the name it is called by.
  std::vector<std::string> words = {interpreter, "-m", "berm", tool};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& w : words) argv.push_back(w.data());
  argv.push_back(nullptr);
  execv(interpreter, argv.data());
  say_error(fmt::format("berm: cannot start {}: {}", interpreter,
             chosen ? "BERM_PYTHON must be the path of a Python interpreter"
                    : "install python3, python3-matplotlib and python3-vtk9"));
  return 1;
}
