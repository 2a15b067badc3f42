#pragma once
/// What two resolved cases say differently.

#include <string>
#include <vector>

namespace berm {

struct Difference {
  std::string key, before, now;  ///< as "body.dam.velocity[1]"; a value that one of them lacks is "absent"
  std::string text() const { return key + " was " + before + ", now it is " + now; }
  /// Points, nodes and their state fit the one value only; else the key may change in a restart.
  bool of_the_model() const;
  /// A prescribed motion: steps take its changes, so that another one counts from the restart on only.
  bool of_a_motion() const;
};

/// Of two texts as Case::resolved has them, in the order of `now`; what only `before` has comes last.
std::vector<Difference> differences(const std::string& before, const std::string& now);

/// A line "key number" for every file that a resolved case names: the number is another one if the file holds something else.
std::string contents_of_files(const std::string& resolved);

}  // namespace berm
