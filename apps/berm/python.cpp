#include "python.hpp"
#include "streams.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>

int run_python(const std::string& module, const std::vector<std::string>& arguments) {
  const char* path = std::getenv("PYTHONPATH");
  const std::string python_path = std::string(BERM_PYTHON_DIR) + (path && *path ? std::string(":") + path : "");
  setenv("PYTHONPATH", python_path.c_str(), 1);
  setenv("PYTHONSAFEPATH", "1", 1);  // else files of the user in the current folder would stand for Python's own: json.py, numbers.py
  // Debian's own interpreter has matplotlib and VTK; another one first in the PATH may not.
  const char* chosen = std::getenv("BERM_PYTHON");
  const char* interpreter = chosen && *chosen ? chosen : "/usr/bin/python3";
  // Python looks for its packages beside the name it is called by.
  std::vector<std::string> words = {interpreter, "-m", module};
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
