#pragma once
/// What Gmsh does not survive.

#include <exception>
#include <functional>
#include <string>

namespace berm {

/// Gmsh 4.8 throws through its parallel regions where parts of a boundary are too near to each other, and that ends the process.
/// As long as this lives it ends with `words` on the terminal and the code of a wrong input. One at a time.
class SayIfGmshEnds {
public:
  explicit SayIfGmshEnds(std::function<std::string()> words);
  ~SayIfGmshEnds();
  SayIfGmshEnds(const SayIfGmshEnds&) = delete;
  SayIfGmshEnds& operator=(const SayIfGmshEnds&) = delete;

private:
  std::terminate_handler before_;
};

}  // namespace berm
