#pragma once
/// A measured or computed curve for the report to compare with.

#include <string>

namespace berm {

struct ReferenceCurve {
  std::string file;       ///< CSV, absolute path
  std::string x, y;       ///< columns as the case names them, e.g. "force [kN]"; empty: those with the names of a history
  std::string delimiter;  ///< between cells; empty: found in the header
  std::string label;      ///< in the legend; empty: as the file says
  bool operator==(const ReferenceCurve&) const = default;
};

}  // namespace berm
