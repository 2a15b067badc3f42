#include "mesh/gmsh_ends.hpp"

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <utility>

#include "base/system_file.hpp"

namespace berm {
namespace {

constexpr int failed = 1, bad_input = 2;  // as main() has it
std::function<std::string()> last_words;

bool memory_is_out() {
  try {
    if (const std::exception_ptr thrown = std::current_exception()) std::rethrow_exception(thrown);
  } catch (const std::bad_alloc&) {
    return true;
  } catch (...) {
  }
  return false;
}

/// A boundary is the same for all processes; memory may be out on one of them.
[[noreturn]] void end() {
  const bool memory = memory_is_out();
  if (memory) std::fputs("berm: no memory left for a mesh: take larger elements, or raise the limit (ulimit -v)\n", stderr);
  if (!memory && is_first_process()) std::fputs((last_words() + "\n").c_str(), stderr);
  std::_Exit(memory ? failed : bad_input);
}

}  // namespace

SayIfGmshEnds::SayIfGmshEnds(std::function<std::string()> words) : before_(std::set_terminate(end)) { last_words = std::move(words); }
SayIfGmshEnds::~SayIfGmshEnds() { std::set_terminate(before_); }

}  // namespace berm
